// The tracer that random_walk_loop.h asks for, over the mesh of an object.
#pragma once

#include "core/subsurface/random_walk.h"

namespace alabaster {

/// Traces a walk's segments in the object space of one mesh. A world direction is mapped but not renormalised, so that
/// t stays the world distance along it.
///
/// Positions are floats. A scattering event nearer to the surface than their rounding could land on its outer side and
/// the walk would be gone: with a mean free path of 1e-5 of the coordinates, one walk in a thousand. So a segment looks
/// that much further, and an event with the surface just ahead of it steps back by as much. Whether it scatters, and
/// with what weight, does not change: the step moves few events, and by less than their spacing.
class MeshTracer {
 public:
  using Hit = TriangleHit;

  MeshTracer(const WalkSpace& space, const Vec3f& p) : space_(space), p_(p) {}

  bool intersect(const Vec3f& direction, float tmax, Hit* hit) {
    const Vec3f d = space_.world_to_object.vector(direction);
    const float rounding = kRounding * (max_abs_component(p_) / length(d) + tmax);
    step_back_ = 0;
    if (!space_.object->intersect({p_, d, tmax + rounding}, hit)) return false;
    if (hit->t <= tmax) return true;
    step_back_ = rounding;
    return false;
  }
  double exit_distance(const Hit& hit) const { return hit.t; }
  bool advance(const Vec3f& direction, float t) {
    p_ += space_.world_to_object.vector(direction) * std::max(0.0f, t - step_back_);
    if (space_.bounds.empty()) return is_finite(p_);
    const Vec3f &lower = space_.bounds.lower, &upper = space_.bounds.upper;
    return p_.x >= lower.x && p_.y >= lower.y && p_.z >= lower.z && p_.x <= upper.x && p_.y <= upper.y &&
           p_.z <= upper.z;
  }

 private:
  static constexpr float kRounding = 4 * 0x1p-23f;

  const WalkSpace& space_;
  Vec3f p_;
  float step_back_ = 0;
};

}  // namespace alabaster
