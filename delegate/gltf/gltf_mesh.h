// One glTF primitive as a mesh description.
#pragma once

#include <optional>

#include "delegate/gltf/gltf_document.h"
#include "delegate/host/retained_scene_delegate.h"

namespace alabaster::hd::gltf {

/// The primitive's topology and primvars, without transform, material path and instancer. Empty if it has no triangles
/// (reported).
///
/// "st" is the coordinate set of the material's textures (textures_of), with KHR_texture_transform applied and v
/// upwards. Primitives with FB_ngon_encoding become catmullClark cages, refined to `refine_level`, whose normals come
/// from refinement; all others get scheme none and keep their normals.
std::optional<host::MeshDescription> translate_primitive(const Document& document, const tinygltf::Primitive& primitive,
                                                         const std::string& element, int refine_level, Report& report);

/// The triangle list of indices drawn in `mode` 4, 5 or 6 (glTF 2.0, section 3.7.2.1: triangles, strip, fan).
std::vector<uint32_t> triangle_list(const std::vector<uint32_t>& indices, int mode);

}  // namespace alabaster::hd::gltf
