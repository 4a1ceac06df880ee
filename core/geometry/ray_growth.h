// Bounds of rays in the spaces of instances: Embree aborts on rays that are too large there.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/geometry/embree_scene.h"

namespace alabaster {

/// The growth by a placement's map into object space: coordinates there stay below stretch * coordinates + shift.
/// Infinite where the map cannot be inverted in float.
struct RayGrowth {
  float stretch = 0, shift = 0;

  static RayGrowth of(const Affine& object_to_world);
  /// The bounds for even poses over the shutter, and in between.
  static RayGrowth of(const std::vector<Affine>& poses);

  void include(const RayGrowth& other) {
    stretch = std::max(stretch, other.stretch);
    shift = std::max(shift, other.shift);
  }
  /// Rays whose origin and direction have no larger components.
  bool allows(float origin, float direction) const {
    return origin * stretch + shift < kTraceLimit && direction * stretch < kTraceLimit;
  }
  bool allows(const Ray& ray) const { return allows(max_abs_component(ray.org), max_abs_component(ray.dir)); }
};

}  // namespace alabaster
