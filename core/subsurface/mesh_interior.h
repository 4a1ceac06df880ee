// The parts of a mesh that only light below its surface asks for: which side is out, and how far the surface is. Each
// is built when it is first asked for and kept with the mesh, so edits of other things never build it again.
#pragma once

#include "core/memory/memory_budget.h"
#include "core/subsurface/built_once.h"
#include "core/subsurface/distance_grid.h"
#include "core/subsurface/shells.h"

namespace alabaster {

/// Any thread. The mesh and its BVH must be the same at each call. Throws BuildCancelled; the next call builds again.
class MeshInterior {
 public:
  /// Counts the parts, also while they are built (MemoryRefused). Called before any other.
  void count_in(std::shared_ptr<MemoryBudget> budget) { budget_ = std::move(budget); }
  /// Shares the topology of other meshes that `cache` serves. Called before it is asked for any part.
  void share_topology(std::shared_ptr<ShellTopologyCache> cache) { topology_ = std::move(cache); }
  const MeshShells& shells(const Mesh& mesh, const ObjectScene& object, const CancelToken& cancel = {}) const {
    return shells_
        .get([&] {
          constexpr size_t kBuildBytes = 84;  // of a triangle: welded corners, edges, their counts, surface, shell
          MemoryReservation memory = hold(mesh, kBuildBytes * mesh.triangles.size());
          Counted<MeshShells> built{find_shells(mesh, object, cancel, topology_.get()), std::move(memory)};
          built.memory.shrink(built.part.triangle_flags.capacity());
          return built;
        })
        .part;
  }
  /// Null if the mesh can have none (build_distance_grid). At most 2 MB.
  const DistanceGrid* distances(const Mesh& mesh, const CancelToken& cancel = {}) const {
    constexpr uint32_t kResolution = 128;
    constexpr size_t kBuildBytes = 5;  // of a voxel: its squared distance beside its cell
    const auto build = [&] {
      MemoryReservation memory = hold(mesh, kBuildBytes * kResolution * kResolution * kResolution);
      Counted<std::shared_ptr<const DistanceGrid>> built{build_distance_grid(mesh, kResolution, cancel),
                                                         std::move(memory)};
      built.memory.shrink(built.part ? built.part->memory_bytes() : 0);
      return built;
    };
    return grid_.get(build).part.get();
  }
  const OpenEdges& open_edges(const Mesh& mesh) const {
    return open_edges_.get([&] { return find_open_edges(mesh); });
  }
  /// All that has been built.
  size_t memory_bytes() const {
    return shells_.measured([](const auto& shells) { return shells.part.triangle_flags.capacity(); }) +
           grid_.measured([](const auto& grid) { return grid.part ? grid.part->memory_bytes() : 0; });
  }

 private:
  template <class T>
  struct Counted {
    T part;
    MemoryReservation memory;
  };
  MemoryReservation hold(const Mesh& mesh, size_t bytes) const {
    return {budget_, MemoryUse::subsurface, bytes,
            "the interior of a mesh of " + std::to_string(mesh.triangles.size()) + " triangles"};
  }

  std::shared_ptr<MemoryBudget> budget_;
  std::shared_ptr<ShellTopologyCache> topology_;  // null: its own, for a moment
  mutable BuiltOnce<Counted<MeshShells>> shells_;
  mutable BuiltOnce<OpenEdges> open_edges_;
  mutable BuiltOnce<Counted<std::shared_ptr<const DistanceGrid>>> grid_;
};

}  // namespace alabaster
