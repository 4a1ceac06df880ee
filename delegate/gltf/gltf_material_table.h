// The factors and textures of a glTF material and its extensions, as rows: the schema is made of them, and materials
// are read by them.
#pragma once

#include <span>
#include <string_view>

#include "delegate/api/types.h"

namespace alabaster::hd::gltf {

/// The value that an input takes from a texture: `output` of texel * scale + bias. Colours are stored as sRGB, numbers
/// as they are; an alpha channel is a number in both.
struct Reading {
  const char* output = "rgb";
  const char* color_space = "raw";
  Vec4f scale{1}, bias{0};
};
inline Reading color_reading() {
  return {"rgb", "sRGB"};
}
inline Reading number_reading(const char* channel) {
  return {channel};
}
/// The alpha channel of a texture whose colours are used as well.
inline Reading alpha_reading() {
  return {"a", "sRGB"};
}

enum class FactorKind { number, color, color_alpha };

/// A factor and the texture that multiplies it, either of which may be missing. Factors out of range are clamped.
struct MaterialRow {
  const char* layer;  // the extension that has it, or kCore; "" for the material itself
  const char* factor = nullptr;
  FactorKind kind = FactorKind::number;
  double low = 0, high = 1, fallback = 0;  // of each component
  const char* texture = nullptr;
  const char* parameter = nullptr;  // of AlabasterDisney: their product. Null: gltf_material.cpp reads the row by name
  Reading reading{};
};

/// Layers follow each other. The first row of a layer has its weight: 0 switches it off.
std::span<const MaterialRow> material_rows();

inline constexpr const char* kCore = "pbrMetallicRoughness";
inline constexpr const char* kAnisotropy = "KHR_materials_anisotropy";
inline constexpr const char* kClearcoat = "KHR_materials_clearcoat";
inline constexpr const char* kDiffuse = "KHR_materials_diffuse_transmission";
inline constexpr const char* kDispersion = "KHR_materials_dispersion";
inline constexpr const char* kEmissiveStrength = "KHR_materials_emissive_strength";
inline constexpr const char* kGlossiness = "KHR_materials_pbrSpecularGlossiness";
inline constexpr const char* kIor = "KHR_materials_ior";
inline constexpr const char* kIridescence = "KHR_materials_iridescence";
inline constexpr const char* kScatter = "KHR_materials_volume_scatter";
inline constexpr const char* kSheen = "KHR_materials_sheen";
inline constexpr const char* kSpecular = "KHR_materials_specular";
inline constexpr const char* kTransmission = "KHR_materials_transmission";
inline constexpr const char* kUnlit = "KHR_materials_unlit";
inline constexpr const char* kVolume = "KHR_materials_volume";
inline constexpr const char* kDisney = "ALAB_materials_disney";

}  // namespace alabaster::hd::gltf
