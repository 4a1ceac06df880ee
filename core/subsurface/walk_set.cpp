#include "core/subsurface/walk_set.h"

namespace alabaster {

Crossed WalkSet::cross(const TriangleHit& hit, const Vec3f& direction) const {
  const Member& m = members[hit.instance];
  const SurfaceHit s = surface_hit(*m.mesh, hit, m.to_set, m.to_object);
  const float side = dot(s.ng, direction) >= 0 ? 1.0f : -1.0f;
  return {m.shells->flags(hit.triangle), leaves(*m.mesh, *m.shells, hit.triangle, m.to_object.vector(direction)),
          offset_point(s.p, s.ng * side, s.offset)};
}

bool WalkSet::contains(const Vec3f& p, const Vec3f& direction, const Member* left) const {
  for (const Member& m : members) {
    if (!m.bounds.contains(p) || !m.shells->any_closed || (&m == left && !m.shells->overlapping)) continue;
    if (winding_number(*m.mesh, *m.shells, *m.object, m.to_object.point(p), m.to_object.vector(direction)) > 0)
      return true;
  }
  return false;
}

Bounds widened(const Bounds& bounds) {
  if (bounds.empty()) return bounds;
  const float diagonal = length(bounds.extent());
  const Vec3f by(diagonal, diagonal, diagonal);
  Bounds wide;
  wide.lower = bounds.lower - by;
  wide.upper = bounds.upper + by;
  return wide;
}

}  // namespace alabaster
