// Four groups of pixels, one of each in every 2 x 2 block:
//   0 1
//   3 2
// How many samples a pixel takes must not depend on what its own samples found: a pixel that ends when it looks good
// ends too often when it missed light. Samples of different pixels are independent, so group g is left to others: group
// g + 1 says where its samples go (core/convergence/sample_allocation.h) and group g + 2 when it ends
// (core/convergence/group_stopping.h), whose own samples went where g + 3 said. Nothing that g found is in any of it, so
// given what decides, each pixel of g is the mean of a fixed number of samples: unbiased, to the letter. (A frame one
// pixel wide or high has two groups only, and decides for itself.)
#pragma once

#include "core/film/film.h"
#include "core/convergence/frame_error.h"

namespace alabaster {

inline constexpr int kPixelGroups = 4;

inline int pixel_group(int x, int y) {
  const int right = x & 1, below = y & 1;
  return below ? 3 - right : right;
}
/// Who decides where the samples of group g go, and when it ends.
constexpr int allocating_group(int g) {
  return (g + 1) % kPixelGroups;
}
constexpr int stopping_group(int g) {
  return (g + 2) % kPixelGroups;
}

/// The pixels of one group, every other column of every other row of `window`, as an image of their own.
struct GroupImage {
  int x0 = 0, y0 = 0;  // of its first pixel
  NoiseImage noise;
};
/// `noise`: of the film with this data window, Film::noise().
GroupImage group_image(const PixelRect& window, const std::vector<PixelNoise>& noise, int group);

/// Copies what `from` has in the pixels of these groups (one bit each). Both films have the same window and AOVs.
void take_groups(const Film& from, uint32_t groups, Film* to);

}  // namespace alabaster
