// Pictures in memory, as the measures of `alabaster tradeoff` take them.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace alabaster::tradeoff {

/// Rows top-down, three floats a pixel: red, green, blue. Scene-linear unless a function says otherwise.
struct Image {
  int width = 0, height = 0;
  std::vector<float> rgb;

  size_t pixels() const { return static_cast<size_t>(width) * static_cast<size_t>(height); }
};

/// The mean of `images`, which must be of one size; summed in double precision. Empty if there are none.
Image mean_image(std::span<const Image> images);

}  // namespace alabaster::tradeoff
