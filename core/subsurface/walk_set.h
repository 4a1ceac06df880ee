// Bodies that scatter as one: the members of a set, the overlapping shells of one mesh, a mesh that is not closed.
// Light passes between members where they overlap or touch.
#pragma once

#include "core/geometry/shells.h"
#include "core/math/bounds.h"

namespace alabaster {

/// Lives in a space of its own, parallel to the world's: its origin is the centre of its bounds, so that precision does
/// not depend on where in the world the set stands.
struct WalkSet {
  struct Member {
    const Mesh* mesh = nullptr;
    const MeshShells* shells = nullptr;
    const ObjectScene* object = nullptr;
    Affine to_set, to_object;
    Bounds bounds;          // in the set's space
    uint32_t instance = 0;  // index into the scene's instances
  };
  std::vector<Member> members;
  std::shared_ptr<const InstancedScene> scene;  // of the members, in their order
  Vec3f origin{0, 0, 0};                        // in render space
  Bounds bounds;                                // where a walk may go, in the set's space

  /// What a line in direction `direction` does at a hit, and the point beyond, in the set's space.
  Crossed cross(const TriangleHit& hit, const Vec3f& direction) const;
  /// Whether a closed shell contains `p`, asked along `direction`. Each member is asked by itself: surfaces of several
  /// that lie on each other could not be told apart. `left`: a member whose surface p lies outside of, or null.
  bool contains(const Vec3f& p, const Vec3f& direction, const Member* left) const;
};

/// Bounds that a walk in an open mesh may reach: the mesh's, widened by their own diagonal on every side. A ground
/// plane so becomes a half-space, and what goes beyond is ended and counted.
Bounds widened(const Bounds& bounds);

}  // namespace alabaster
