#include "delegate/view/data_view.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace alabaster::view {
namespace {

// Neighbouring numbers get colours that differ: the fractional parts of multiples of the golden ratio's powers.
void color_of_id(float id, float* rgb) {
  const double n = double(id) + 1;
  for (int i = 0; i < 3; ++i) {
    constexpr double kSteps[] = {0.819172513396, 0.671043606704, 0.549700477902};
    const double part = n * kSteps[i];
    rgb[i] = id < 0 ? 0.0f : float(0.25 + 0.7 * (part - std::floor(part)));
  }
}

}  // namespace

DataKind data_kind(const std::string& aov) {
  if (aov == "normal" || aov == "Neye") return DataKind::direction;
  if (aov == "Peye" || aov == "position" || aov == "uv" || aov == "motion" || aov.starts_with("primvars:"))
    return DataKind::vector;
  if (aov == "primId" || aov == "instanceId" || aov == "elementId" || aov == "materialId") return DataKind::id;
  for (const char* name :
       {"depth", "cameraDepth", "cameraDistance", "ambientOcclusion", "sampleCount", "nonfiniteSamples", "alpha"})
    if (aov == name) return DataKind::number;
  return DataKind::light;
}

std::array<float, 2> finite_range(const float* pixels, const int32_t* ids, size_t count, size_t components) {
  float low = std::numeric_limits<float>::infinity(), high = -low;
  for (size_t i = 0; i < count; ++i) {
    if (ids && ids[i] < 0) continue;
    for (size_t c = 0; c < components; ++c)
      if (const float v = pixels[i * components + c]; std::isfinite(v))
        low = std::min(low, v), high = std::max(high, v);
  }
  return low < high    ? std::array{low, high}
         : low == high ? std::array{std::min(low, 0.0f), std::max(high, 1.0f)}
                       : std::array{0.0f, 1.0f};
}

void DataView::Apply(std::span<float> rgba) const {
  for (size_t i = 0; i + 3 < rgba.size(); i += 4) {
    float* const p = &rgba[i];
    if (kind_ == DataKind::id) {
      color_of_id(p[0], p);
    } else if (kind_ == DataKind::direction) {
      for (int c = 0; c < 3; ++c) p[c] = 0.5f + 0.5f * p[c];
    } else {
      const float width = range_[1] - range_[0];
      for (int c = 0; c < 3; ++c) p[c] = (p[c] - range_[0]) / width;
      if (kind_ == DataKind::number) p[1] = p[2] = p[0];
    }
    for (int c = 0; c < 3; ++c) p[c] = std::isfinite(p[c]) ? std::clamp(p[c], 0.0f, 1.0f) : 1.0f;
    p[3] = 1;
  }
}

void GrayLight::Apply(std::span<float> rgba) const {
  for (size_t i = 0; i + 3 < rgba.size(); i += 4) rgba[i + 1] = rgba[i + 2] = rgba[i];
  if (display_) display_->Apply(rgba);
}

}  // namespace alabaster::view
