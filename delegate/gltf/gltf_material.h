// Translates glTF materials into networks of AlabasterDisney, AlabasterTexture and AlabasterPrimvar nodes.
#pragma once

#include "delegate/gltf/gltf_document.h"

namespace alabaster::hd::gltf {

/// The primvar that holds TEXCOORD_n: "st", "st1", "st2" and so on.
inline std::string uv_set_name(int n) {
  return n == 0 ? "st" : "st" + std::to_string(n);
}

/// The vertex colours of the primitives that have a material.
struct VertexColors {
  bool colors = false, alphas = false;
};
/// For each material of the document.
std::vector<VertexColors> find_vertex_colors(const Document& document);

/// The network of `materials[index]`, with its nodes below `id`. delegate/manual/gltf.md has the table.
/// Textures that the extension ALAB_materials_disney names are colours (sRGB) for colours of the surface, and numbers
/// for everything else.
MaterialNetwork translate_material(const Document& document, size_t index, const VertexColors& vertex, const Path& id,
                                   Report& report);

}  // namespace alabaster::hd::gltf
