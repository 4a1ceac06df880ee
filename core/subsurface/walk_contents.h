// What stands in a body, as a walk meets it.
#pragma once

#include <functional>
#include <optional>

#include "core/geometry/embree_scene.h"
#include "core/subsurface/walk_medium.h"

namespace alabaster {

/// Of one walk. Everything is in render space; hits have the scene's indices.
class WalkContents {
 public:
  virtual ~WalkContents() = default;
  /// True for an opaque face of the body's own mesh.
  virtual bool is_opaque(const TriangleHit& hit) const = 0;
  /// Whether the walk passes the wall that its segment along `direction` has met: a point beyond it to trace on from.
  /// Empty: the walk ends there. Drawn anew at each call.
  virtual std::optional<Vec3f> beyond(const TriangleHit& hit, const Vec3f& direction) = 0;
  /// A segment after so many scattering events. Lights are met on its way without an end to it: `passing(t)` is the
  /// walk's throughput where it has passed distance t.
  virtual void meet_lights(const Ray& segment, uint32_t events,
                           const std::function<ChannelValues(double)>& passing) = 0;
};

}  // namespace alabaster
