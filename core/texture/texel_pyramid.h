// Means of an image over boxes of texels, each level half as large as the one before. Internal to this room.
#pragma once

#include <array>
#include <bit>
#include <vector>

#include "core/diagnostics/cancel.h"
#include "core/texture/texel_plane.h"

namespace alabaster {

/// The weighted means of a level's texels. A texel counts by its alpha, because a surface shows its colour where it is
/// opaque; transparent ones count where there is nothing else.
struct TexelMeans {
  Vec2i size{0, 0};
  std::vector<Vec4f> sums;  // colour times weight, and weight; rows from the top

  static Vec4f sum_of(const Rgb& color, float alpha);
  const Vec4f& at(int x, int y) const { return sums[size_t(y) * size_t(size.x) + size_t(x)]; }
};

/// The means as texels of `count` halves or floats, 1 or 3.
template <class Element>
PackedTexels<Element> packed(const TexelMeans& means, int count) {
  PackedTexels<Element> texels{means.size, {}, {}};
  texels.elements.reserve(means.sums.size() * size_t(count));
  for (const Vec4f& sum : means.sums)
    for (int c = 0; c < count; ++c)
      if constexpr (sizeof(Element) == sizeof(float))
        texels.elements.push_back(std::bit_cast<Element>(sum[c] / sum.w));
      else
        texels.elements.push_back(Imath::half(sum[c] / sum.w).bits());
  return texels;
}

/// The half as large level, of at least one texel: each holds the mean over its part of the image. An odd row is cut in
/// boxes a little wider than two texels, which share the texels between them. `at(x, y)`: the finer level's sums.
/// Throws BuildCancelled.
template <class At>
TexelMeans halved(const Vec2i& size, const At& at, const CancelToken& cancel);

/// The texels that a box covers along an axis: `first` and up to two more, by their shares of its width.
struct BoxShares {
  int first = 0, count = 0;
  std::array<float, 3> shares{};
};
/// The shares of all boxes over an axis of `texels`.
std::vector<BoxShares> box_shares(int boxes, int texels);

template <class At>
TexelMeans halved(const Vec2i& size, const At& at, const CancelToken& cancel) {
  TexelMeans means;
  means.size = {std::max(size.x / 2, 1), std::max(size.y / 2, 1)};
  means.sums.reserve(size_t(means.size.x) * size_t(means.size.y));
  const std::vector<BoxShares> columns = box_shares(means.size.x, size.x);
  for (const BoxShares& row : box_shares(means.size.y, size.y)) {
    cancel.check();
    for (const BoxShares& column : columns) {
      Vec4f sum(0, 0, 0, 0);
      for (int j = 0; j < row.count; ++j)
        for (int i = 0; i < column.count; ++i)
          sum += at(column.first + i, row.first + j) * (row.shares[size_t(j)] * column.shares[size_t(i)]);
      means.sums.push_back(sum);
    }
  }
  return means;
}

}  // namespace alabaster
