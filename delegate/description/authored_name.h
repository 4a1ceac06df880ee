// Names of prims as the authors of models gave them.
#pragma once

#include <string>

#include "delegate/api/types.h"

namespace alabaster::hd::description {

/// The name that the author of a model gave: "skin" for "/gltf/bust/materials/2_skin", "head" for the mesh primitive
/// "/gltf/bust/nodes/3_head/0". Names in overrides and descriptions match it. `is_mesh`: the path is that of a mesh.
ALABASTER_API std::string AuthoredName(const Path& path, bool is_mesh);

}  // namespace alabaster::hd::description
