#include "core/texture/texel_pyramid.h"

#include <algorithm>

namespace alabaster {

Vec4f TexelMeans::sum_of(const Rgb& color, float alpha) {
  constexpr float kLeastWeight = 1.0f / 1024;
  const float weight = std::max(alpha, kLeastWeight);
  return {color.r * weight, color.g * weight, color.b * weight, weight};
}

PackedTexels<uint16_t> packed(const TexelMeans& means, int count) {
  PackedTexels<uint16_t> texels{means.size, {}, {}};
  texels.elements.reserve(means.sums.size() * size_t(count));
  for (const Vec4f& sum : means.sums)
    for (int c = 0; c < count; ++c) texels.elements.push_back(Imath::half(sum[c] / sum.w).bits());
  return texels;
}

// With texels odd, 2 n + 1, boxes n: each is 2 + 1/n wide.
BoxShares box_shares(int i, int boxes, int texels) {
  const double width = static_cast<double>(texels) / boxes, begin = i * width, end = begin + width;
  BoxShares box{static_cast<int>(begin), {}};
  for (int k = 0; k < 3; ++k) {
    const int texel = box.first + k;
    const double covered = std::min(end, texel + 1.0) - std::max(begin, static_cast<double>(texel));
    if (texel < texels && covered > 0) box.shares[size_t(k)] = static_cast<float>(covered / width);
  }
  return box;
}

}  // namespace alabaster
