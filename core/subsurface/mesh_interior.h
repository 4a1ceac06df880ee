// The parts of a mesh that only light below its surface asks for: which side is out, and how far the surface is. Each
// is built when it is first asked for and kept with the mesh, so edits of other things never build it again.
#pragma once

#include "core/subsurface/built_once.h"
#include "core/subsurface/distance_grid.h"
#include "core/subsurface/shells.h"

namespace alabaster {

/// Any thread. The mesh and its BVH must be the same at each call. Throws BuildCancelled; the next call builds again.
class MeshInterior {
 public:
  const MeshShells& shells(const Mesh& mesh, const ObjectScene& object, const CancelToken& cancel = {}) const {
    return shells_.get([&] { return find_shells(mesh, object, cancel); });
  }
  /// Null if the mesh can have none (build_distance_grid). At most 2 MB.
  const DistanceGrid* distances(const Mesh& mesh, const CancelToken& cancel = {}) const {
    constexpr uint32_t kResolution = 128;
    return grid_.get([&] { return build_distance_grid(mesh, kResolution, cancel); }).get();
  }
  /// All that has been built.
  size_t memory_bytes() const {
    return shells_.measured([](const MeshShells& shells) { return shells.triangle_flags.capacity(); }) +
           grid_.measured([](const auto& grid) { return grid ? grid->memory_bytes() : 0; });
  }

 private:
  mutable BuiltOnce<MeshShells> shells_;
  mutable BuiltOnce<std::shared_ptr<const DistanceGrid>> grid_;
};

}  // namespace alabaster
