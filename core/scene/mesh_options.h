// Options of a mesh beside its shape and its materials. A prim's record, the scene's description and the snapshot hold
// the same struct.
#pragma once

#include <cstdint>
#include <span>

#include "core/parameter/parameter.h"

namespace alabaster {

/// The faces that camera rays pass.
enum class CameraCull : uint8_t { none, back, front, all };

struct MeshOptions {
  bool double_sided = true;  // of materials whose `sides` leave it to the mesh
  CameraCull camera_cull = CameraCull::none;
  // Rows of mesh_parameters():
  bool visible_to_camera = true;  // false: CameraCull::all
  bool holdout = false;           // a camera's path that meets it first ends there, without colour
  bool shadow_catcher = false;    // the same, and alpha is the shadow that other meshes cast there
  bool crypto_instances = false;  // read by who names what is drawn (SceneDescription::mattes)
  bool operator==(const MeshOptions&) const = default;
};

/// One row for each option that a scene delegate gives as a constant primvar of that name, in the order of
/// schemas/mesh.json.
std::span<const Parameter<MeshOptions>> mesh_parameters();

}  // namespace alabaster
