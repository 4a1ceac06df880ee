// Multilinear tables of directional albedos that have no closed form, filled by quadrature when they are first needed.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

namespace alabaster {

/// A function of the unit cube of as many dimensions as there are numbers of cells. Value: a number or a vector.
template <class Value, int... kCells>
class AlbedoTable {
 public:
  static constexpr size_t kDimensions = sizeof...(kCells);
  using Place = std::array<float, kDimensions>;

  /// `integrate(place)` gives the values at the corners of the cells.
  template <class Integrate>
  explicit AlbedoTable(const Integrate& integrate) {
    for (size_t i = 0; i < kSize; ++i) {
      Place place;
      size_t rest = i;
      for (size_t d = 0; d < kDimensions; ++d) {
        const size_t corners = kCorners[d];
        place[d] = static_cast<float>(rest % corners) / static_cast<float>(corners - 1);
        rest /= corners;
      }
      values_[i] = integrate(place);
    }
  }

  /// Coordinates are clamped to [0,1].
  Value at(const Place& place) const {
    size_t first = 0;
    Place within{};
    for (size_t d = 0, stride = 1; d < kDimensions; stride *= kCorners[d++]) {
      const int cells = static_cast<int>(kCorners[d]) - 1;
      const float x = std::clamp(place[d], 0.0f, 1.0f) * static_cast<float>(cells);
      const int cell = std::min(static_cast<int>(x), cells - 1);
      within[d] = x - static_cast<float>(cell);
      first += stride * static_cast<size_t>(cell);
    }
    return between<kDimensions>(first, kSize, within);
  }

 private:
  static constexpr std::array<size_t, kDimensions> kCorners{static_cast<size_t>(kCells + 1)...};
  static constexpr size_t kSize = (static_cast<size_t>(kCells + 1) * ...);

  // Interpolates along the last of the first n dimensions; `size`: of the values that these have together.
  template <size_t n>
  Value between(size_t first, size_t size, const Place& within) const {
    if constexpr (n == 0) {
      return values_[first];
    } else {
      const size_t stride = size / kCorners[n - 1];
      const Value low = between<n - 1>(first, stride, within), high = between<n - 1>(first + stride, stride, within);
      return low + (high - low) * within[n - 1];
    }
  }

  std::array<Value, kSize> values_{};
};

}  // namespace alabaster
