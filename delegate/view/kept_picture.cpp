#include "delegate/view/kept_picture.h"

#include <algorithm>
#include <atomic>

#include "delegate/view/picture_fetcher.h"

namespace alabaster::view {
namespace {

std::atomic<uint64_t> g_kept{0};

size_t components_of(hd::Format format) {
  return size_t(std::clamp(hd::FormatComponents(format), 1, 4));
}

}  // namespace

KeptPicture::KeptPicture() : RenderBuffer("/view/kept"), number_(++g_kept) {}

std::shared_ptr<KeptPicture> KeptPicture::copy(hd::RenderBuffer* from) {
  if (!from) return nullptr;
  constexpr hd::Format kFormats[] = {hd::Format::float32, hd::Format::float32vec2, hd::Format::float32vec3,
                                     hd::Format::float32vec4};
  const std::shared_ptr<KeptPicture> kept(new KeptPicture);
  const size_t components = components_of(from->GetFormat());
  hd::PixelMemory memory;
  memory.format = kept->format_ = kFormats[components - 1];
  if (!resolve(from, components, &memory, &kept->pixels_)) return nullptr;
  kept->size_ = memory.size;
  return kept;
}

bool KeptPicture::ResolveTo(hd::PixelMemory* memory) {
  if (!(memory->size == size_)) {
    memory->size = size_;
    return false;
  }
  if (memory->shown == number_) return true;
  const size_t components = components_of(format_), wanted = components_of(memory->format);
  const auto width = size_t(size_.x);
  std::vector<float> row(4 * width);
  for (size_t y = 0; y < size_t(size_.y); ++y) {
    for (size_t i = 0; i < row.size(); ++i)
      row[i] = i % 4 < components ? pixels_[(y * width + i / 4) * components + i % 4] : float(i % 4 == 3);
    if (memory->transform) memory->transform->Apply(row);
    uint8_t* const to = static_cast<uint8_t*>(memory->pixels) + y * memory->rowBytes;
    auto* const numbers = static_cast<float*>(static_cast<void*>(to));
    for (size_t i = 0; i < wanted * width; ++i) {
      const float value = row[4 * (i / wanted) + i % wanted];
      if (memory->format == hd::Format::unorm8vec4)
        to[i] = value > 0 ? uint8_t(std::min(value, 1.0f) * 255 + 0.5f) : uint8_t(0);
      else
        numbers[i] = value;
    }
  }
  memory->shown = number_;
  return true;
}

}  // namespace alabaster::view
