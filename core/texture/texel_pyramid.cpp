#include "core/texture/texel_pyramid.h"

#include <algorithm>

namespace alabaster {

Vec4f TexelMeans::sum_of(const Rgb& color, float alpha) {
  constexpr float kLeastWeight = 1.0f / 1024;
  const float weight = std::max(alpha, kLeastWeight);
  return {color.r * weight, color.g * weight, color.b * weight, weight};
}

// An odd number of texels, 2 n + 1, makes n boxes that are 2 + 1/n wide, and none of them reaches a fourth texel.
std::vector<BoxShares> box_shares(int boxes, int texels) {
  const double width = static_cast<double>(texels) / boxes;
  std::vector<BoxShares> all(static_cast<size_t>(boxes));
  for (int i = 0; i < boxes; ++i) {
    BoxShares& box = all[static_cast<size_t>(i)];
    const double begin = i * width, end = begin + width;
    box.first = static_cast<int>(begin);
    while (box.count < 3 && box.first + box.count < std::min(end, static_cast<double>(texels))) {
      const double texel = box.first + box.count;
      box.shares[size_t(box.count++)] = static_cast<float>((std::min(end, texel + 1) - std::max(begin, texel)) / width);
    }
  }
  return all;
}

}  // namespace alabaster
