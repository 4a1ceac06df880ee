// Translates glTF materials into networks of one AlabasterDisney node and AlabasterTexture nodes.
#pragma once

#include "delegate/gltf/gltf_document.h"
#include "delegate/host/retained_scene_delegate.h"

namespace alabaster::hd::gltf {

/// Features of a material that the Disney BSDF lacks are approximated, and the loss is reported.
///
/// Metallic-roughness, KHR_materials_ior, _specular and _emissive_strength carry over unchanged.
/// _clearcoat: clearcoat = factor. The GTR1 lobe's alpha mix(.1, .001, gloss) (Burley 2012, section 5.4) is set to
///   roughness^2, so clearcoatGloss = (.1 - roughness^2) / .099.
/// _sheen: sheen = largest component of sheenColorFactor. sheenTint = the mix of white and the base colour's tint, that
///   of the sheen lobe, nearest to sheenColorFactor / sheen by least squares. Its roughness has no counterpart.
/// _volume with _volume_scatter: subsurface. baseColor = multiscatterColor. The extinction of the volume,
///   sigma_t = -ln(attenuationColor) / attenuationDistance, fixes scatterDistance d by sigma_t (1-g) = 1 / (d s(A)),
///   s(A) = 1.9 - A + 3.5 (A - .8)^2 (Chiang, Kutz, Burley 2016, eq. 3), per channel, so that the walk uses the file's
///   sigma_t again. g = scatterAnisotropy, clamped to -0.9..0.9.
///   multiscatterColorTexture (sRGB, from a later draft) multiplies baseColor, but d is that of the factor alone.
/// ALAB_materials_disney: parameters by the node's own names, which override all of the above. baseColorTexture (sRGB)
///   and scatterDistanceTexture (numbers, no conversion) multiply their parameters, which are 1 by default.
MaterialNetwork translate_material(const Document& document, size_t index, const Path& id, Report& report);

/// The primvar that holds TEXCOORD_n: "st", "st1", "st2" and so on.
inline std::string uv_set_name(int n) {
  return n == 0 ? "st" : "st" + std::to_string(n);
}

/// A texture that is used, and its texture coordinates.
struct TextureUse {
  int index = -1;  // in `textures`; -1: none
  int coordinates = 0;
  const tinygltf::Value* transform = nullptr;  // KHR_texture_transform; null: none
};
struct TextureUses {
  TextureUse base_color, scatter_distance;
};
TextureUses textures_of(const tinygltf::Material& material);

/// The scatterDistance of one channel; 0 (Lambert) where light is attenuated at once. An `attenuation_color` >= 1 (no
/// attenuation) counts as .999, because a walk must end.
float scatter_distance(double attenuation_color, double attenuation_distance, double albedo, double g);

}  // namespace alabaster::hd::gltf
