// Closed meshes with exact volume and surface area from their triangles, and points on them, for tests of walks on
// meshes.
#pragma once

#include <functional>
#include <vector>

#include "core/geometry/embree_scene.h"

namespace alabaster::testing {

/// Axis-parallel box about the origin. Triangles 0, 1 are its top (+y), 2, 3 its bottom.
Mesh box_mesh(const Vec3f& half_extents);
/// About the y axis; not convex. `segments` around, half as many across the tube.
Mesh torus_mesh(float radius, float tube_radius, int segments);

/// Computed from the triangles, in double.
double mesh_area(const Mesh& mesh);
double mesh_volume(const Mesh& mesh);  // of a closed mesh wound counter-clockwise from outside

/// Points distributed uniformly over a mesh's surface.
class SurfaceSampler {
 public:
  /// Triangles for which `included` answers false have no points; empty: all have.
  explicit SurfaceSampler(const Mesh& mesh, const std::function<bool(size_t triangle)>& included = {});
  /// Triangle and barycentric coordinates; `u` in [0,1)^3.
  TriangleHit sample(const std::array<float, 3>& u) const;

 private:
  std::vector<double> area_up_to_;  // of the triangles up to and including this one
};

}  // namespace alabaster::testing
