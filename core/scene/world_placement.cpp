#include "core/scene/world_placement.h"

#include <cmath>

#include "core/geometry/embree_scene.h"

namespace alabaster {

BoundsDouble world_bounds(const Bounds& object, const Matrix4d& object_to_world) {
  BoundsDouble world;
  if (object.empty()) return world;
  for (const Vec3f& corner : object.corners()) world.extend(transform_point(Vec3d(corner), object_to_world));
  return world;
}

bool is_within_reach(const Matrix4d& m) {
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j)
      if (!(std::abs(m[i][j]) < double(kTraceLimit))) return false;
  return true;
}

bool is_within_reach(const BoundsDouble& bounds) {
  const double limit = kTraceLimit;
  return bounds.lower.x > -limit && bounds.lower.y > -limit && bounds.lower.z > -limit && bounds.upper.x < limit &&
         bounds.upper.y < limit && bounds.upper.z < limit;
}

Matrix4d moved_to(Matrix4d m, const Vec3d& origin) {
  for (int i = 0; i < 3; ++i) m[3][i] -= origin[i];
  return m;
}

}  // namespace alabaster
