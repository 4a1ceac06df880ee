// The events of one walk, for those who want to see it.
#pragma once

#include <vector>

#include "core/math/vector.h"
#include "core/subsurface/walk_medium.h"

namespace alabaster {

struct WalkStep {
  enum class Kind { scatter, sphere_step, exit };
  Kind kind;
  Vec3f direction;  // unit, world
  double distance;  // through the medium, world
};
using WalkRecord = std::vector<WalkStep>;

/// A tracer of bodies in which lights may stand.
template <class Tracer>
concept MeetsLights = requires(const Tracer& tracer, const typename Tracer::Hit* hit) {
  tracer.meet_lights(Vec3f(), 1.0f, hit, 0u, [](double) { return ChannelValues(); });
};

/// A tracer that writes down how a walk moves it. The walk is the same with and without.
template <class Tracer>
class RecordingTracer {
 public:
  using Hit = typename Tracer::Hit;

  RecordingTracer(const Tracer& tracer, WalkRecord* record) : tracer_(tracer), record_(record) {}

  bool intersect(const Vec3f& direction, float tmax, Hit* hit) {
    traced_ = true;
    return tracer_.intersect(direction, tmax, hit);
  }
  double exit_distance(const Hit& hit) const { return tracer_.exit_distance(hit); }
  template <class Passing>
  void meet_lights(const Vec3f& direction, float tmax, const Hit* hit, uint32_t events,
                   const Passing& passing) const requires MeetsLights<Tracer> {
    tracer_.meet_lights(direction, tmax, hit, events, passing);
  }
  bool bounds_distance() const { return tracer_.bounds_distance(); }
  double distance_bound(double worthwhile) const { return tracer_.distance_bound(worthwhile); }
  /// A sphere step moves without a segment traced before it.
  bool advance(const Vec3f& direction, float t) {
    record_->push_back({traced_ ? WalkStep::Kind::scatter : WalkStep::Kind::sphere_step, direction, double(t)});
    traced_ = false;
    return tracer_.advance(direction, t);
  }

 private:
  Tracer tracer_;
  WalkRecord* record_;
  bool traced_ = false;
};

}  // namespace alabaster
