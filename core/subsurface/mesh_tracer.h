// The tracers that random_walk_loop.h asks for: over the mesh of an object, and over the union of several shells.
#pragma once

#include "core/subsurface/random_walk.h"
#include "core/subsurface/walk_set.h"

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

  MeshTracer(const WalkSpace& space, const Vec3f& p) : space_(space), p_(p), entry_(p) {}

  /// The walk has come `distance` through the medium when it begins.
  void start_below(float distance) { behind_ = distance; }

  bool intersect(const Vec3f& direction, float tmax, Hit* hit) {
    const Vec3f d = space_.world_to_object.vector(direction);
    tmax = std::max(0.0f, tmax - behind_);
    const float rounding = kRounding * (max_abs_component(p_) / length(d) + tmax);
    step_back_ = 0;
    if (!space_.object->intersect({p_, d, tmax + rounding}, hit)) return false;
    if (hit->t <= tmax) return true;
    step_back_ = rounding;
    return false;
  }
  double exit_distance(const Hit& hit) const { return hit.t + behind_; }
  bool bounds_distance() const { return space_.distances != nullptr; }
  double distance_bound(double worthwhile) const {
    // No surface is further than where the walk began: most never leave that neighbourhood, and need not look.
    const Vec3f moved = p_ - entry_;
    const double least = worthwhile / space_.distance_scale;
    if (dot(moved, moved) < least * least) return 0;
    return space_.distances->bound(p_) * space_.distance_scale;
  }
  bool advance(const Vec3f& direction, float t) {
    p_ += space_.world_to_object.vector(direction) * std::max(0.0f, t - behind_ - step_back_);
    step_back_ = behind_ = 0;
    return space_.bounds.empty() ? is_finite(p_) : space_.bounds.contains(p_);
  }

 private:
  static constexpr float kRounding = 4 * 0x1p-23f;

  const WalkSpace& space_;
  Vec3f p_, entry_;
  float step_back_ = 0;
  float behind_ = 0;  // of the first segment
};

/// Traces a walk's segments in the union of the closed shells of a set. It keeps no depth that could go wrong: it
/// passes what it enters, and what it leaves is the end of the medium unless a shell contains the far side.
///
/// An open shell has the medium on one side, unbounded: a walk that entered it from behind (`from_behind`) leaves it to
/// there, and passes it the other way.
class SetTracer {
 public:
  using Hit = TriangleHit;

  SetTracer(const WalkSet& set, const Vec3f& p, bool from_behind) : set_(set), p_(p), from_behind_(from_behind) {}

  void start_below(float distance) { behind_ = distance; }  // as MeshTracer

  bool intersect(const Vec3f& direction, float tmax, Hit* hit) {
    tmax = std::max(0.0f, tmax - behind_);
    const float rounding = kRounding * (max_abs_component(p_) + tmax);
    Vec3f from = p_;
    float passed = 0;
    step_back_ = 0;
    for (int i = 0; i < kMaxCrossings; ++i) {
      if (!set_.scene->intersect({from, direction, tmax - passed + rounding}, hit)) return false;
      passed += hit->t;
      const Crossed crossed = set_.cross(*hit, direction);
      if (ends_medium(crossed, direction, set_.members[hit->instance])) {
        hit->t = passed;
        if (passed <= tmax) return true;
        step_back_ = rounding;
        return false;
      }
      if (!(passed <= tmax)) return false;
      from = crossed.beyond;
    }
    return false;
  }
  double exit_distance(const Hit& hit) const { return hit.t + behind_; }
  bool advance(const Vec3f& direction, float t) {
    p_ += direction * std::max(0.0f, t - behind_ - step_back_);
    behind_ = 0;
    return set_.bounds.contains(p_);
  }

 private:
  // Twice through a member's transform: see MeshTracer for what this is.
  static constexpr float kRounding = 32 * 0x1p-23f;

  bool ends_medium(const Crossed& crossed, const Vec3f& direction, const WalkSet::Member& member) const {
    if (crossed.flags & MeshShells::kInner) return false;
    const bool behind = crossed.flags & MeshShells::kOpen && from_behind_;
    if (crossed.leaves == behind) return false;
    return !set_.contains(crossed.beyond, direction, &member);
  }

  const WalkSet& set_;
  Vec3f p_;
  bool from_behind_;
  float step_back_ = 0;
  float behind_ = 0;  // of the first segment
};

}  // namespace alabaster
