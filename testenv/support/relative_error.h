// The true error of a picture, against one with many more samples: the yardstick of core/convergence/frame_error.h.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/convergence/frame_error.h"

namespace alabaster::testing {

/// Relative mean square error E^2 of frame_error.h, with the reference's levels. Both pictures as Film::resolve_float
/// gives them (RGBA, row-major).
inline double relative_mse(const std::vector<float>& image, const std::vector<float>& reference, int width,
                           int height) {
  const auto at = [&](int x, int y) { return 4 * (size_t(y) * size_t(width) + size_t(x)); };
  const auto level = [&](int x, int y) {
    const float* p = &reference[at(x, y)];
    return (double(p[0]) + double(p[1]) + double(p[2])) / 3;
  };
  const double pixels = double(width) * height;
  double mean = 0, sum = 0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) mean += level(x, y) / pixels;
  if (!(mean > 0)) return 0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      double around = 0, squared = 0;
      int count = 0;
      for (int ny = std::max(0, y - 1); ny <= std::min(height - 1, y + 1); ++ny)
        for (int nx = std::max(0, x - 1); nx <= std::min(width - 1, x + 1); ++nx, ++count) around += level(nx, ny);
      for (size_t c = 0; c < 3; ++c)
        squared += std::pow(double(image[at(x, y) + c]) - double(reference[at(x, y) + c]), 2) / 3;
      sum += squared / (std::pow(around / count, 2) + std::pow(kErrorFloor * mean, 2)) / pixels;
    }
  return sum;
}

}  // namespace alabaster::testing
