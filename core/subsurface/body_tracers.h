// The tracers that random_walk_loop.h asks for: over the mesh of a lone object, and over a union.
//
// Positions are floats. A scattering event nearer to the surface than their rounding could land on its outer side, and
// the walk would be gone: with a mean free path of 1e-5 of the coordinates, one walk in a thousand. So a segment looks
// that much further, and an event with the surface just ahead of it steps back by as much. The choice to scatter and
// its weight do not change: the step moves few events, and by less than their spacing.
#pragma once

#include "core/subsurface/body.h"
#include "core/subsurface/shells.h"
#include "core/subsurface/walk_contents.h"

namespace alabaster {

/// Traces a walk's segments in the space of one mesh. A world direction is mapped but not renormalised, so that t stays
/// the world distance along it.
class MeshTracer {
 public:
  using Hit = TriangleHit;

  struct Start {
    Vec3f p;                  // in the mesh's space
    float entry_distance;     // the way through the medium from the surface to p, which counts for the first segment
    const Affine& to_object;  // at the walk's time
    float time;               // of the shutter
  };

  MeshTracer(const SubsurfaceBody& body, const Start& start)
      : member_(body.members.front()),
        to_object_(start.to_object),
        bounds_(body.bounds),
        p_(start.p),
        entry_(start.p),
        untraced_(start.entry_distance),
        time_(start.time) {}

  bool intersect(const Vec3f& direction, float tmax, Hit* hit) {
    const Vec3f d = to_object_.vector(direction);
    tmax = std::max(0.0f, tmax - untraced_);
    const float rounding = kRounding * (max_abs_component(p_) / length(d) + tmax);
    step_back_ = 0;
    if (!member_.object->intersect({p_, d, tmax + rounding, time_}, hit)) return false;
    if (hit->t <= tmax) {
      prefetch_triangle(*member_.mesh, hit->triangle);
      return true;
    }
    step_back_ = rounding;
    return false;
  }
  double exit_distance(const Hit& hit) const { return hit.t + untraced_; }
  bool bounds_distance() const { return member_.distances && member_.room_for_spheres; }
  double distance_bound(double worthwhile) const {
    // No surface is further than where the walk began: most never leave that neighbourhood, and need not look.
    const Vec3f moved = p_ - entry_;
    const double least = worthwhile / member_.least_stretch;
    if (dot(moved, moved) < least * least) return 0;
    return member_.distances->bound(p_) * member_.least_stretch;
  }
  bool advance(const Vec3f& direction, float t) {
    p_ += to_object_.vector(direction) * std::max(0.0f, t - untraced_ - step_back_);
    step_back_ = untraced_ = 0;
    return bounds_.empty() ? is_finite(p_) : bounds_.contains(p_);
  }

 private:
  static constexpr float kRounding = 4 * 0x1p-23f;

  const SubsurfaceBody::Member& member_;
  const Affine& to_object_;
  const Bounds& bounds_;
  Vec3f p_, entry_;
  float step_back_ = 0;
  float untraced_;  // of the first segment
  float time_;
};

/// Traces a walk's segments in the union of the closed shells of a body's members. The tracer keeps no depth that could
/// go wrong: it passes what it enters, and what it leaves is the end of the medium unless a shell contains the far
/// side. So are the walls of what stands in the body.
///
/// An open shell has the medium on one side, unbounded: a walk that entered it from behind leaves it to there, and
/// passes it the other way.
class UnionTracer {
 public:
  using Hit = TriangleHit;

  struct Start {
    uint32_t member;         // whose surface the walk entered through
    Vec3f p;                 // body space
    float entry_distance;    // as for MeshTracer
    bool from_behind;        // through the inner side of an open shell: the medium is on its outer side
    float time;              // of the shutter
    WalkContents* contents;  // of a body that has some
  };

  UnionTracer(const SubsurfaceBody& body, const Start& start)
      : body_(body),
        contents_(start.contents),
        room_for_spheres_(body.members[start.member].room_for_spheres),
        from_behind_(start.from_behind),
        p_(start.p),
        entry_(start.p),
        untraced_(start.entry_distance),
        time_(start.time) {}

  bool intersect(const Vec3f& direction, float tmax, Hit* hit) {
    tmax = std::max(0.0f, tmax - untraced_);
    const float rounding = rounding_at(p_) + kRounding * tmax;
    Vec3f from = p_;
    float passed = 0;
    step_back_ = 0;
    for (int i = 0; i < kMaxCrossings; ++i) {
      if (!body_.scene->intersect({from, direction, tmax - passed + rounding, time_}, hit)) return false;
      passed += hit->t;
      const std::optional<Vec3f> beyond = pass(*hit, direction);
      if (!beyond) {
        hit->t = passed;
        if (passed <= tmax) return true;
        step_back_ = rounding;
        return false;
      }
      if (!(passed <= tmax)) return false;
      from = *beyond;
    }
    return false;
  }
  /// The lights on a segment that was traced to `tmax`, or to the hit. Before the tracer advances.
  template <class Passing>
  void meet_lights(const Vec3f& direction, float tmax, const Hit* hit, uint32_t events, const Passing& passing) const {
    if (!body_.lights_within) return;
    const float reach = hit ? hit->t : std::max(0.0f, tmax - untraced_);
    contents_->meet_lights({p_ + body_.origin, direction, reach, time_}, events,
                           [&](double t) { return passing(t + static_cast<double>(untraced_)); });
  }
  double exit_distance(const Hit& hit) const { return hit.t + untraced_; }
  bool bounds_distance() const { return room_for_spheres_ && body_.bounds_distances(); }
  /// A sphere that no member's surface cuts lies in the medium as its centre does.
  double distance_bound(double worthwhile) const {
    const Vec3f moved = p_ - entry_;
    if (dot(moved, moved) < worthwhile * worthwhile) return 0;
    double nearest = std::numeric_limits<double>::infinity();
    for (const SubsurfaceBody::Member& m : body_.members) {
      nearest = std::min(nearest, distance_to(m) - static_cast<double>(rounding_at(p_)));
      if (!(nearest >= worthwhile)) return 0;
    }
    if (body_.occupied) nearest = std::min(nearest, body_.distance_to_contents(p_) - double(rounding_at(p_)));
    return nearest;
  }
  bool advance(const Vec3f& direction, float t) {
    p_ += direction * std::max(0.0f, t - untraced_ - step_back_);
    step_back_ = untraced_ = 0;
    return body_.bounds.contains(p_);
  }

 private:
  // Twice through a member's transform.
  static constexpr float kRounding = 32 * 0x1p-23f;
  static float rounding_at(const Vec3f& p) { return kRounding * max_abs_component(p); }

  // A point beyond the surface that was met. Empty: the medium ends there, or another body's wall stands in it.
  std::optional<Vec3f> pass(const Hit& hit, const Vec3f& direction) const {
    const bool is_content = hit.instance >= body_.members.size();
    if (is_content || body_.opaque_faces) [[unlikely]] {
      TriangleHit of_scene = hit;
      of_scene.instance =
          is_content ? body_.contents[hit.instance - body_.members.size()] : body_.members[hit.instance].instance;
      if (is_content) {
        const auto beyond = contents_->beyond(of_scene, direction);
        return beyond ? std::optional(*beyond - body_.origin) : std::nullopt;
      }
      if (contents_->is_opaque(of_scene)) return std::nullopt;
    }
    const Crossed crossed = body_.cross(hit, direction);
    if (ends_medium(crossed, direction, body_.members[hit.instance])) return std::nullopt;
    return crossed.beyond;
  }
  bool ends_medium(const Crossed& crossed, const Vec3f& direction, const SubsurfaceBody::Member& member) const {
    if (crossed.flags & MeshShells::kInner) return false;
    const bool behind = crossed.flags & MeshShells::kOpen && from_behind_;
    if (crossed.leaves == behind) return false;
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    return !body_.contains_in_body_space({crossed.beyond, direction, kInfinity, time_}, &member);
  }
  double distance_to(const SubsurfaceBody::Member& m) const {
    if (!m.bounds.contains(p_)) return distance_to_bounds(m.bounds, p_);
    std::optional<SubsurfaceBody::Maps> moved;
    return static_cast<double>(m.distances->bound(m.at(time_, &moved).to_object.point(p_))) * m.least_stretch;
  }

  const SubsurfaceBody& body_;
  WalkContents* contents_;
  bool room_for_spheres_, from_behind_;
  Vec3f p_, entry_;
  float step_back_ = 0;
  float untraced_;  // of the first segment
  float time_;
};

}  // namespace alabaster
