// Tangents for normal maps, as MikkTSpace makes them (Mikkelsen 2008, "Simulation of Wrinkled Surfaces Revisited",
// section 3.4): baking programs bake against these.
#pragma once

#include <array>
#include <map>
#include <mutex>
#include <string>

#include "core/geometry/mesh.h"
#include "core/memory/memory_budget.h"

namespace alabaster {

/// Object space. Per corner the direction in which u grows, unit and perpendicular to the corner's normal, and in w the
/// sign of n x t along growing v. Corners of equal position, normal and uv, on triangles that wind alike in uv, share
/// the mean over their triangles, weighted by angle. Zero where no triangle around has an area in uv.
MeshAttribute<Vec4f> compute_tangents(const Mesh& mesh, const MeshAttribute<Vec2f>& uvs);

/// The tangents of a mesh by uv set, computed when first asked for, and kept while held. Any
/// thread. The mesh must be the same at each call, and outlive what is returned.
class TangentCache {
 public:
  using Tangents = std::shared_ptr<const MeshAttribute<Vec4f>>;
  /// Counts the tangents, also while they are computed (MemoryRefused). Called before any other.
  void count_in(std::shared_ptr<MemoryBudget> budget) { budget_ = std::move(budget); }
  /// The change of u and of v of an image per unit of u and v of a set.
  using Axes = std::array<Vec2f, 2>;
  /// The authored ones if the mesh has some; null without that uv set. Otherwise they are computed from the coordinates
  /// of the image, which `axes` turns.
  Tangents of(const Mesh& mesh, const UvSetName& uv_set, const Axes& axes = {Vec2f(1, 0), Vec2f(0, 1)}) const;
  size_t memory_bytes() const;

 private:
  struct Counted {
    MeshAttribute<Vec4f> tangents;
    MemoryReservation memory;
  };
  /// `axes` null: of the set itself.
  Counted compute(const Mesh& mesh, const MeshAttribute<Vec2f>& uvs, const Axes* axes) const;
  static bool turns(const Axes& axes);

  std::shared_ptr<MemoryBudget> budget_;
  mutable std::mutex mutex_;
  mutable std::map<std::string, std::weak_ptr<const Counted>> computed_;
};

}  // namespace alabaster
