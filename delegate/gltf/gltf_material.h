// Translates glTF materials into networks of AlabasterDisney, AlabasterTexture and AlabasterPrimvar nodes.
#pragma once

#include "delegate/gltf/gltf_material_builder.h"

namespace alabaster::hd::gltf {

/// The network of `materials[index]`, with its nodes below `id`. delegate/manual/gltf.md has the table.
/// Textures that the extension ALAB_materials_disney names are colours (sRGB) for colours of the surface, and numbers
/// for everything else.
MaterialNetwork translate_material(const Document& document, size_t index, const VertexColors& vertex, const Path& id,
                                   Report& report);

/// The scatterDistance of one channel; 0 (Lambert) where light is attenuated at once. An `attenuation_color` >= 1 (no
/// attenuation) counts as .999, because a walk must end.
float scatter_distance(double attenuation_color, double attenuation_distance, double albedo, double g);

}  // namespace alabaster::hd::gltf
