// Means of an image over boxes of texels, each level half as large as the one before. Internal to this room.
#pragma once

#include <array>
#include <vector>

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

/// The means as texels of `count` halves, 1 or 3.
PackedTexels<uint16_t> packed(const TexelMeans& means, int count);

/// The half as large level, of at least one texel: each holds the mean over its part of the image. An odd row is cut in
/// boxes a little wider than two texels, which share the texels between them. `at(x, y)`: the finer level's sums.
template <class At>
TexelMeans halved(const Vec2i& size, const At& at);

/// The texels that a box covers along an axis: `first` and up to two more, by their shares of its width.
struct BoxShares {
  int first;
  std::array<float, 3> shares;
};
/// Of box `i` of `boxes` over `texels`, at most twice as many and a half.
BoxShares box_shares(int i, int boxes, int texels);

template <class At>
TexelMeans halved(const Vec2i& size, const At& at) {
  TexelMeans means;
  means.size = {std::max(size.x / 2, 1), std::max(size.y / 2, 1)};
  means.sums.reserve(size_t(means.size.x) * size_t(means.size.y));
  for (int y = 0; y < means.size.y; ++y) {
    const BoxShares rows = box_shares(y, means.size.y, size.y);
    for (int x = 0; x < means.size.x; ++x) {
      const BoxShares columns = box_shares(x, means.size.x, size.x);
      Vec4f sum(0, 0, 0, 0);
      for (int j = 0; j < 3; ++j)
        for (int i = 0; i < 3; ++i)
          if (const float share = rows.shares[size_t(j)] * columns.shares[size_t(i)]; share > 0)
            sum += at(columns.first + i, rows.first + j) * share;
      means.sums.push_back(sum);
    }
  }
  return means;
}

}  // namespace alabaster
