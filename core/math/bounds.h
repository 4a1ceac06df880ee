// Axis-aligned boxes.
#pragma once

#include <array>
#include <limits>

#include "core/math/vector.h"

namespace alabaster {

/// Empty (lower > upper) by default.
template <class T>
struct BasicBounds {
  using Point = Imath::Vec3<T>;
  Point lower{std::numeric_limits<T>::infinity()}, upper{-std::numeric_limits<T>::infinity()};

  bool empty() const { return !(lower.x <= upper.x && lower.y <= upper.y && lower.z <= upper.z); }
  bool contains(const Point& p) const {
    return p.x >= lower.x && p.y >= lower.y && p.z >= lower.z && p.x <= upper.x && p.y <= upper.y && p.z <= upper.z;
  }
  void extend(const Point& p) {
    lower = {std::min(lower.x, p.x), std::min(lower.y, p.y), std::min(lower.z, p.z)};
    upper = {std::max(upper.x, p.x), std::max(upper.y, p.y), std::max(upper.z, p.z)};
  }
  void extend(const BasicBounds& b) {
    if (b.empty()) return;
    extend(b.lower);
    extend(b.upper);
  }
  Point center() const { return lower * T(0.5) + upper * T(0.5); }
  Point extent() const { return empty() ? Point(T(0)) : upper - lower; }
  /// In binary order: bit i of the index chooses the upper side along axis i.
  std::array<Point, 8> corners() const {
    std::array<Point, 8> all;
    for (size_t i = 0; i < 8; ++i)
      all[i] = {i & 1 ? upper.x : lower.x, i & 2 ? upper.y : lower.y, i & 4 ? upper.z : lower.z};
    return all;
  }
};
using Bounds = BasicBounds<float>;
using BoundsDouble = BasicBounds<double>;

/// From a point to the nearest one of the box; 0 inside.
inline double distance_to_bounds(const Bounds& bounds, const Vec3f& p) {
  Vec3d outside(0, 0, 0);
  for (int i = 0; i < 3; ++i)
    outside[i] =
        std::max(0.0, std::max(double(bounds.lower[i]) - double(p[i]), double(p[i]) - double(bounds.upper[i])));
  return length(outside);
}

}  // namespace alabaster
