// What a path carries from vertex to vertex, and what a vertex is.
#pragma once

#include "core/geometry/surface_hit.h"
#include "core/integrator/path_integrator.h"

namespace alabaster {

struct PathState {
  Ray ray;
  Rgb throughput{1.0f};
  Rgb radiance{0.0f};
  float scatter_pdf = 0;  // of the ray's direction; 0 for the camera ray, which no light sampling competes with
  uint32_t depth = 0;
  uint32_t walk_events = 0;  // of the last subsurface walk; any other carrier of light counts as many
};

// A point on a surface as seen along a ray: all normals on the viewer's side.
struct PathVertex {
  const Instance* instance = nullptr;
  TriangleHit triangle;
  SurfaceHit hit;
  Frame frame;  // about the shading normal, bent so that the viewer is above it
  Vec3f outer;  // ray origin on the viewer's side
  DisneyParameters material;
};

// The hit with all normals on the side that `towards` leaves to.
inline SurfaceHit surface_on_side(const Instance& instance, const TriangleHit& triangle, const Vec3f& towards) {
  SurfaceHit hit = surface_hit(instance.prototype->mesh, triangle, instance.object_to_world, instance.world_to_object);
  if (dot(hit.ng, towards) < 0) {
    hit.ng = -hit.ng;
    hit.ns = -hit.ns;
    hit.ng_object = -hit.ng_object;
  }
  return hit;
}

}  // namespace alabaster
