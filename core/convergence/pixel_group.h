// Four groups of pixels, one of each in every 2 x 2 block:
//   0 1
//   3 2
// A pixel that ends when it looks good ends too often when it has missed light, so the number of a pixel's samples must
// not depend on what they found. Samples of different pixels are independent, so other groups decide: group g + 1
// allocates the samples of g (sample_allocation.h), and group g + 2, whose own samples g + 3 allocated, ends it
// (group_stopping.h). None of this depends on what g found. Given what decides, each pixel of g is the mean of a fixed
// number of samples, and unbiased. A frame one pixel wide or high has two groups only, and decides for itself.
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
/// The group that decides where the samples of g go, and the group that decides when g ends.
constexpr int allocating_group(int g) {
  return (g + 1) % kPixelGroups;
}
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

/// Copies the pixels of these groups (one bit each). Both films have the same window and AOVs.
void take_groups(const Film& from, uint32_t groups, Film* to);

}  // namespace alabaster
