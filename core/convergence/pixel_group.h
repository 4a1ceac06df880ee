// Four groups of pixels, one of each in every 2 x 2 block:
//   0 1
//   3 2
// A pixel that ends when it looks good ends too often when it has missed light, so the number of a pixel's samples must
// not depend on what they found. Samples of different pixels are independent, so other groups decide: groups g + 1 and
// g + 3, the other colour of a chessboard, allocate the samples of g (sample_allocation.h) and of g + 2, and g + 2 ends
// g (group_stopping.h). Allocation reads the pilot alone, in which all pixels have as many samples, so groups may
// allocate for each other; it must not be repeated. None of this depends on what g found. Given what decides, each
// pixel of g is the mean of a fixed number of samples, and unbiased. A frame one pixel wide or high has two groups
// only: each allocates the samples of the other, and the frame ends itself.
//
// Light paths bind pixels: one that lands in a pixel has not landed in another, and a frame's light paths are one set
// of points. In adaptive frames of a caustic no bias was seen within half a per cent of the light
// (testenv/statistical/unbiased_stopping_test.cpp).
#pragma once

#include "core/convergence/frame_error.h"
#include "core/film/film.h"

namespace alabaster {

inline constexpr int kPixelGroups = 4;
inline constexpr uint32_t kAllPixelGroups = (1u << kPixelGroups) - 1;  // one bit each

inline int pixel_group(int x, int y) {
  const int right = x & 1, below = y & 1;
  return below ? 3 - right : right;
}
/// True if pixels of group g allocate the samples of group h, and those of h the samples of g.
constexpr bool allocates(int g, int h) {
  return ((g ^ h) & 1) != 0;
}
/// The group that decides when g ends.
constexpr int stopping_group(int g) {
  return (g + 2) % kPixelGroups;
}

/// The pixels of one group, every other column of every other row of `window`, as an image of their own.
struct GroupImage {
  int x0 = 0, y0 = 0;  // of the first pixel
  NoiseImage noise;
};
/// `noise`: Film::noise() of a film with this data window.
GroupImage group_image(const PixelRect& window, const std::vector<PixelNoise>& noise, int group);

/// These take the pixels of `groups`, one bit each. Both films, or both tiles, have the same window, AOVs and extras.
void copy_groups(const Film& from, uint32_t groups, Film* to);
void exchange_groups(uint32_t groups, Film* a, Film* b);
/// `rect`: of both tiles.
void exchange_groups(const PixelRect& rect, uint32_t groups, FilmTile* a, FilmTile* b);

}  // namespace alabaster
