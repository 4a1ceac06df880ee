#include "core/film/pixel_noise.h"

#include <cmath>

namespace alabaster {

// Independent samples of variance v: the mean of n has variance v / n, and the expected squared difference of means of
// a and b samples is v / a + v / b.
float PixelNoise::deviation() const {
  if (samples < 2) return 0;
  const double m = std::bit_floor(samples), rest = samples - m;
  const double variance = m / samples;  // of the mean, with v = m
  return static_cast<float>(std::sqrt(variance / (uses_tail(samples) ? 1 + m / rest : 4))) * difference();
}

}  // namespace alabaster
