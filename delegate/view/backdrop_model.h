// A mesh as a glTF file, for what a render description cannot say: the backdrop of a studio. Internal to this room.
#pragma once

#include "delegate/host/retained_scene_delegate.h"

namespace alabaster::view {

/// A .glb with one node of this name and a material of the same name, two-sided. `mesh` has points and normals, one per
/// vertex, and faces of three or four corners.
std::vector<uint8_t> model_of_mesh(const hd::host::MeshDescription& mesh, const std::string& name);

}  // namespace alabaster::view
