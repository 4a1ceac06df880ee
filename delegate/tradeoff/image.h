// Pictures in memory, for the measurements of `alabaster tradeoff`.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace alabaster::tradeoff {

/// Rows top-down, three floats per pixel: red, green, blue. Scene-linear unless a function says otherwise.
struct Image {
  int width = 0, height = 0;
  std::vector<float> rgb;

  size_t pixels() const { return static_cast<size_t>(width) * static_cast<size_t>(height); }
};

/// The mean of `images`, which must all have one size; summed in double precision. Empty if there are none.
Image mean_image(std::span<const Image> images);

}  // namespace alabaster::tradeoff
