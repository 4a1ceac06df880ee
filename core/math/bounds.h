#pragma once

#include <limits>

#include "core/math/vector.h"

namespace alabaster {

/// Axis-aligned box; empty (lower > upper) by default.
struct Bounds {
  Vec3f lower{std::numeric_limits<float>::infinity(), std::numeric_limits<float>::infinity(),
              std::numeric_limits<float>::infinity()};
  Vec3f upper{-std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity(),
              -std::numeric_limits<float>::infinity()};

  bool empty() const { return !(lower.x <= upper.x && lower.y <= upper.y && lower.z <= upper.z); }
  bool contains(const Vec3f& p) const {
    return p.x >= lower.x && p.y >= lower.y && p.z >= lower.z && p.x <= upper.x && p.y <= upper.y && p.z <= upper.z;
  }
  void extend(const Vec3f& p) {
    lower = {std::min(lower.x, p.x), std::min(lower.y, p.y), std::min(lower.z, p.z)};
    upper = {std::max(upper.x, p.x), std::max(upper.y, p.y), std::max(upper.z, p.z)};
  }
  void extend(const Bounds& b) {
    if (b.empty()) return;
    extend(b.lower);
    extend(b.upper);
  }
  Vec3f center() const { return lower * 0.5f + upper * 0.5f; }
  Vec3f extent() const { return empty() ? Vec3f(0, 0, 0) : upper - lower; }
};

/// From a point to the nearest one of the box; 0 inside.
inline double distance_to_bounds(const Bounds& bounds, const Vec3f& p) {
  Vec3d outside(0, 0, 0);
  for (int i = 0; i < 3; ++i)
    outside[i] =
        std::max(0.0, std::max(double(bounds.lower[i]) - double(p[i]), double(p[i]) - double(bounds.upper[i])));
  return length(outside);
}

}  // namespace alabaster
