// The noise of one pixel, as far as its own samples tell.
#pragma once

#include <bit>
#include <cstdint>

namespace alabaster {

/// Differences between means of a pixel's samples: the root of the square averaged over red, green and blue, because
/// the square itself does not fit a float in a picture as bright as 1e30 or as dim as 1e-30. m is the largest power of
/// two that the number of samples has reached. core/convergence/frame_error.md says what a frame learns from them.
struct PixelNoise {
  uint32_t samples = 0;
  float level = 0;     // mean of red, green and blue
  float latest = 0;    // between the two halves of the first m samples
  float previous = 0;  // between the two halves of the first m / 2
  float earlier = 0;   // between the two halves of the first m / 4
  float tail = 0;      // between the first m samples and those after them; 0 if there are none

  /// The tail is compared instead of the halves once it is half as long as they are together.
  static bool uses_tail(uint32_t samples) {
    const uint32_t m = std::bit_floor(samples);
    return samples - m >= (m + 1) / 2 && samples > m;
  }
  /// The difference with most samples behind it.
  float difference() const { return uses_tail(samples) ? tail : latest; }
  /// Standard deviation of the pixel's mean, as if its samples were independent: one pixel cannot tell how fast it
  /// converges. 0 for less than two samples.
  float deviation() const;
};

}  // namespace alabaster
