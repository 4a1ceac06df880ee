#include "core/color/ocio_transform.h"

#include <algorithm>
#include <cmath>
#include <mutex>

namespace OCIO = OCIO_NAMESPACE;

namespace alabaster {
namespace {

constexpr size_t kBlock = 2048;  // pixels: 32 KB of stack

class OcioTransform final : public ColorTransform {
 public:
  OcioTransform(OCIO::ConstCPUProcessorRcPtr cpu, float scale, float largest)
      : cpu_(std::move(cpu)), scale_(scale), largest_(largest) {}

  void apply(float* rgba, size_t count) const override {
    for (size_t done = 0; done < count; done += kBlock) apply_block(rgba + 4 * done, std::min(kBlock, count - done));
  }
  bool is_noop() const override { return !cpu_ && scale_ == 1; }

 private:
  // OCIO works on a copy: alpha stays out of its reach, because its ACES outputs spread a NaN in alpha to all channels.
  void apply_block(float* rgba, size_t count) const {
    std::array<float, 4 * kBlock> block;
    for (size_t i = 0; i < count; ++i) {
      for (size_t c = 0; c < 3; ++c) block[4 * i + c] = scrubbed(rgba[4 * i + c] * scale_);
      block[4 * i + 3] = 1;
    }
    if (cpu_) {
      OCIO::PackedImageDesc image(block.data(), long(count), 1, 4);
      cpu_->apply(image);
    }
    for (size_t i = 0; i < count; ++i)
      for (size_t c = 0; c < 3; ++c) rgba[4 * i + c] = finite(block[4 * i + c]);
  }
  float scrubbed(float v) const { return std::isfinite(v) ? std::clamp(v, -largest_, largest_) : 0.0f; }
  static float finite(float v) { return std::isnan(v) ? 0.0f : std::clamp(v, -kLargestFloat, kLargestFloat); }

  OCIO::ConstCPUProcessorRcPtr cpu_;  // null: identity
  float scale_, largest_;
};

std::mutex quiet_mutex;
int quiet_depth = 0;
OCIO::LoggingLevel quiet_saved = OCIO::LOGGING_LEVEL_DEFAULT;

}  // namespace

std::shared_ptr<const ColorTransform> make_transform(const OCIO::ConstProcessorRcPtr& processor, float scale,
                                                     float largest) {
  OCIO::ConstCPUProcessorRcPtr cpu;
  if (processor && !processor->isNoOp()) cpu = processor->getDefaultCPUProcessor();
  return std::make_shared<OcioTransform>(std::move(cpu), scale, largest);
}

QuietOcio::QuietOcio() {
  const std::lock_guard lock(quiet_mutex);
  if (quiet_depth++ > 0) return;
  quiet_saved = OCIO::GetLoggingLevel();
  OCIO::SetLoggingLevel(OCIO::LOGGING_LEVEL_NONE);
}

QuietOcio::~QuietOcio() {
  const std::lock_guard lock(quiet_mutex);
  if (--quiet_depth == 0) OCIO::SetLoggingLevel(quiet_saved);
}

}  // namespace alabaster
