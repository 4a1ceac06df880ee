// Meshes that deform, as the renderer traces them: at even times over the shutter.
#pragma once

#include "delegate/prims/render_param.h"
#include "delegate/prims/scene_translation.h"

namespace alabaster::hd::prims {

/// Keeps what it has built for as long as the mesh and the shutter are the same.
class Deformations {
 public:
  /// The deforming meshes of `records` in the shutter, with their BVHs, built in the delegate's arena. A mesh whose
  /// build was cancelled or failed (reported) is missing: it is drawn as it is at time 0.
  DeformedMeshes in(const Shutter& shutter, const Records& records, SceneParam* param);

 private:
  struct Built {
    std::shared_ptr<const Deformation> from;
    Shutter shutter;
    std::shared_ptr<const MeshPrototype> prototype;
  };
  std::map<Path, Built> built_;
};

}  // namespace alabaster::hd::prims
