// Meshes that deform, as the renderer traces them: at even times over the shutter.
#pragma once

#include "delegate/prims/built_meshes.h"
#include "delegate/prims/scene_translation.h"

namespace alabaster::hd::prims {

/// Keeps what it has built for as long as the mesh and the shutter are the same.
class Deformations {
 public:
  /// Those of `meshes` that deform, in the shutter, with their BVHs, built in the delegate's arena. A mesh that memory
  /// does not suffice for (reported, once) is missing: it is drawn as it is at time 0, and the next call tries again.
  /// Throws BuildCancelled.
  DeformedMeshes in(const Shutter& shutter, const BuiltMeshes& meshes, SceneParam* param, const CancelToken& cancel);
  /// Memory did not suffice for some mesh.
  bool incomplete() const;
  /// Adds those of meshes that the selection shows.
  void add_faults(const Records& records, const support::Selection& selection, SceneFaults* faults) const;

 private:
  struct Built {
    std::shared_ptr<const Deformation> from;
    Shutter shutter;
    std::shared_ptr<const MeshPrototype> prototype;  // null: there is a fault
    std::optional<SceneFault> fault;                 // reported when it came
  };
  static void build(const Path& path, const MeshPrototype& still, Built* built, SceneParam* param,
                    const CancelToken& cancel);
  std::map<Path, Built> built_;
};

}  // namespace alabaster::hd::prims
