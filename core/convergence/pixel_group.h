// Four groups of pixels, each a random sample of the frame. A quad is 2 x 2 pixels. Each block of 2 x 2 quads has one
// quad of each group, in an order that a hash of the block's place chooses. So no pattern of a picture, such as stripes
// or a chessboard, lies in one group more than in another, and the pixels of a quad show a group a pattern of two
// pixels as the frame has it.
//
// A pixel that ends when it looks good ends too often when it has missed light, so the number of a pixel's samples must
// not depend on what they found. Samples of different pixels are independent, so other groups decide. Those of the
// other parity, g + 1 and g + 3, allocate the samples of g (sample_allocation.h) and of g + 2. The error of g + 2 ends
// g (group_stopping.h).
//
// Proof that a pixel of g stays unbiased. Its group is a function of its coordinates. Its number of samples is a
// function of (a) the pilot samples of g + 1 and g + 3, which allocate, (b) all samples of g + 2, whose error is
// estimated from them alone, and (c) how many samples those are, which (a) decides. Allocation reads the pilot samples
// alone, of which all pixels have the same number. So groups may allocate for each other, but only once per frame. The
// group g + 2 is traced while g or g + 2 has not ended, so it is traced while g has not. So no sample of g is among
// (a), (b) and (c). Given those, the pixel is the mean of a fixed number of samples. The order of the groups in a block
// does not enter. In a frame within one block, or of a few pixels, the group that decides may be empty: then a group
// ends itself, and is biased a little.
#pragma once

#include "core/film/film.h"
#include "core/sampling/pixel_sampler.h"

namespace alabaster {

inline constexpr int kPixelGroups = 4;
inline constexpr uint32_t kAllPixelGroups = (1u << kPixelGroups) - 1;  // one bit each

inline int pixel_group(int x, int y) {
  // The 24 orders of four groups, two bits for each quad.
  static constexpr uint8_t kOrders[] = {0xe4, 0xb4, 0xd8, 0x78, 0x9c, 0x6c, 0xe1, 0xb1, 0xc9, 0x39, 0x8d, 0x2d,
                                        0xd2, 0x72, 0xc6, 0x36, 0x4e, 0x1e, 0x93, 0x63, 0x87, 0x27, 0x4b, 0x1b};
  const uint32_t block = hash_combine(hash32(static_cast<uint32_t>(x >> 2)), static_cast<uint32_t>(y >> 2));
  const int quad = (y & 2) | (x >> 1 & 1);
  return kOrders[block % std::size(kOrders)] >> (2 * quad) & 3;
}
/// True if pixels of group g allocate the samples of group h, and those of h the samples of g.
constexpr bool allocates(int g, int h) {
  return ((g ^ h) & 1) != 0;
}
/// The group that decides when g ends.
constexpr int stopping_group(int g) {
  return (g + 2) % kPixelGroups;
}
inline bool is_in(uint32_t groups, int x, int y) {
  return groups == kAllPixelGroups || (groups >> pixel_group(x, y) & 1) != 0;
}

/// These take the pixels of `groups`, one bit each. Both films, or both tiles, have the same window, AOVs and extras.
void copy_groups(const Film& from, uint32_t groups, Film* to);
void exchange_groups(uint32_t groups, Film* a, Film* b);
/// `rect`: of both tiles.
void exchange_groups(const PixelRect& rect, uint32_t groups, FilmTile* a, FilmTile* b);

}  // namespace alabaster
