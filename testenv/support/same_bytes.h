// Compares pictures to the bit.
#pragma once

#include <cstring>
#include <vector>

#include "core/film/film.h"

namespace alabaster::testing {

template <class T>
bool same_bytes(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

/// The part of a picture of four channels, `width` pixels wide, that a crop shows.
inline std::vector<float> cut_out(const std::vector<float>& picture, int width, const PixelRect& crop) {
  std::vector<float> part;
  for (int y = crop.y0; y < crop.y1; ++y) {
    const auto row = picture.begin() + 4 * (y * width + crop.x0);
    part.insert(part.end(), row, row + 4 * crop.width());
  }
  return part;
}

}  // namespace alabaster::testing
