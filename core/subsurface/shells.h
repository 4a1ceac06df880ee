// The shells of a mesh: which way is out, whatever the winding says, and where there is no inside.
#pragma once

#include <limits>

#include "core/geometry/embree_scene.h"
#include "core/geometry/shell_topology.h"
#include "core/geometry/surface_hit.h"

namespace alabaster {

/// A shell is a set of triangles connected by edges that two of them share, after welding points by position. A closed
/// shell has no other edges. The sign of its volume says which side is out, so that neither a mesh turned inside out
/// nor single turned faces matter; except that a shell inside another one that winds the other way is a cavity, and out
/// is into it. Triangles that lie on each other count once. Two that lie back to back are a wall within a body where
/// other triangles continue them, part of a closed shell where one of each such pair closes it, else an open sheet.
struct MeshShells {
  enum Flag : uint8_t {
    kReversed = 1,  // winds clockwise seen from outside
    kOpen = 2,      // of a shell that is not closed: has no inside
    kInner = 4,     // a wall within a body: no surface to light
  };
  std::vector<uint8_t> triangle_flags;  // empty: closed shells that wind outward, all of them
  bool any_open = false, any_closed = false;
  /// Some surface lies inside a closed shell of the same mesh, or is a wall: the body is the union of its shells. Of a
  /// shell that goes through itself alone 4096 points are looked at: less than that share of the area may be
  /// overlooked, and of the light that goes in there.
  bool overlapping = false;
  /// Twice the volume over the area, of the closed shell where that is least; and a triangle of it. Object space.
  float least_thickness = std::numeric_limits<float>::infinity();
  uint32_t thinnest = 0;

  uint8_t flags(uint32_t triangle) const { return triangle_flags.empty() ? uint8_t(0) : triangle_flags[triangle]; }
};

/// `object` traces `mesh`. A mesh that deforms has the shells of the shutter's opening; several shells of such a mesh
/// count as overlapping, because they may overlap later. The result depends on the mesh alone, not on the number of
/// threads, and scaling the mesh by 2^k does not change it. `cache` may be null. Throws BuildCancelled.
MeshShells find_shells(const Mesh& mesh, const ObjectScene& object, const CancelToken& cancel = {},
                       ShellTopologyCache* cache = nullptr);

/// True if a line in direction `direction` (object space) leaves the triangle's shell at a hit, false if it enters. The
/// outer side of an open shell is the one that would be out if little is missing; of a plane, the one from which it
/// winds counter-clockwise.
bool leaves(const Mesh& mesh, const MeshShells& shells, const TriangleHit& hit, const Vec3f& direction);

/// The surface that a line has just met, and a point beyond it to trace on from.
struct Crossed {
  uint8_t flags = 0;  // MeshShells::Flag
  bool leaves = false;
  Vec3f beyond{0, 0, 0};

  /// +1 leaves a closed shell, -1 enters one, 0 for open shells and walls within.
  int crossing() const { return flags & (MeshShells::kOpen | MeshShells::kInner) ? 0 : leaves ? 1 : -1; }
};

/// In object space.
Crossed cross_surface(const Mesh& mesh, const MeshShells& shells, const TriangleHit& hit, const Vec3f& direction);

/// A line that has crossed so many surfaces is not followed further. No scene has so many along a line.
inline constexpr int kMaxCrossings = 1 << 16;

/// The number of closed shells that contain the ray's origin (object space), by the balance of crossings along the ray:
/// a cavity takes one away. `counts(triangle)`: true if the triangle's shell counts.
template <class Counts>
int winding_number(const Mesh& mesh, const MeshShells& shells, const ObjectScene& object, Ray ray,
                   const Counts& counts) {
  int winding = 0;
  TriangleHit hit;
  for (int i = 0; i < kMaxCrossings && object.intersect(ray, &hit); ++i) {
    const Crossed crossed = cross_surface(mesh, shells, hit, ray.dir);
    if (counts(hit.triangle)) winding += crossed.crossing();
    ray.org = crossed.beyond;
  }
  return winding;
}
inline int winding_number(const Mesh& mesh, const MeshShells& shells, const ObjectScene& object, const Ray& ray) {
  return winding_number(mesh, shells, object, ray, [](uint32_t) { return true; });
}

}  // namespace alabaster
