// Tangents for normal maps, as MikkTSpace makes them (Mikkelsen 2008, "Simulation of Wrinkled Surfaces Revisited",
// section 3.4): baking programs bake against these.
#pragma once

#include <map>
#include <mutex>
#include <string>

#include "core/geometry/mesh.h"

namespace alabaster {

/// Object space. Per corner the direction in which u grows, unit and perpendicular to the corner's normal, and in w the
/// sign of n x t along growing v. Corners of equal position, normal and uv, on triangles that wind alike in uv, share
/// the mean over their triangles, weighted by angle. Zero where no triangle around has an area in uv.
MeshAttribute<Vec4f> compute_tangents(const Mesh& mesh, const MeshAttribute<Vec2f>& uvs);

/// The tangents of a mesh by uv set, each computed when it is first asked for. Any thread. The mesh must be the same at
/// each call.
class TangentCache {
 public:
  /// The authored ones if the mesh has some; null without that uv set.
  const MeshAttribute<Vec4f>* of(const Mesh& mesh, const UvSetName& uv_set) const;
  size_t memory_bytes() const;

 private:
  mutable std::mutex mutex_;
  mutable std::map<std::string, MeshAttribute<Vec4f>> computed_;
};

}  // namespace alabaster
