// Meshes that deform, as the renderer traces them: at even times over the shutter. For AOV motion their points at the
// ends of its time.
#pragma once

#include "delegate/prims/built_meshes.h"
#include "delegate/prims/scene_translation.h"

namespace alabaster::hd::prims {

/// Keeps what it has built for as long as the mesh and the times are the same.
class Deformations {
 public:
  /// Those of `meshes` that deform, in the shutter, with their BVHs, built in the delegate's arena. Throws
  /// BuildCancelled and MemoryRefused.
  DeformedMeshes in(const Shutter& shutter, const MotionTime& motion, const BuiltMeshes& meshes, SceneParam* param,
                    const CancelToken& cancel);

 private:
  struct Built {
    std::shared_ptr<const Deformation> from;
    Shutter shutter;
    std::shared_ptr<const MeshPrototype> prototype;  // null: the last call has ended in an exception
    MotionTime motion;
    std::shared_ptr<const MeshEnds> ends;
  };
  std::map<Path, Built> built_;
};

}  // namespace alabaster::hd::prims
