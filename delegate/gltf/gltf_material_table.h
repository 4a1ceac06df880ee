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
  std::string_view layer;   // the extension that has it, or kCore; "" for the material itself
  std::string_view factor;  // empty: none
  FactorKind kind = FactorKind::number;
  double low = 0, high = 1, fallback = 0;  // of each component
  const char* texture = nullptr;
  const char* parameter = nullptr;  // of AlabasterDisney: their product. Null: gltf_material.cpp reads the row by name
  Reading reading{};
};

/// Layers follow each other. The first row of a layer has its weight: 0 switches it off.
std::span<const MaterialRow> material_rows();

inline constexpr std::string_view kCore = "pbrMetallicRoughness";
inline constexpr std::string_view kAnisotropy = "KHR_materials_anisotropy";
inline constexpr std::string_view kClearcoat = "KHR_materials_clearcoat";
inline constexpr std::string_view kDiffuse = "KHR_materials_diffuse_transmission";
inline constexpr std::string_view kDispersion = "KHR_materials_dispersion";
inline constexpr std::string_view kEmissiveStrength = "KHR_materials_emissive_strength";
inline constexpr std::string_view kGlossiness = "KHR_materials_pbrSpecularGlossiness";
inline constexpr std::string_view kIor = "KHR_materials_ior";
inline constexpr std::string_view kIridescence = "KHR_materials_iridescence";
inline constexpr std::string_view kScatter = "KHR_materials_volume_scatter";
inline constexpr std::string_view kSheen = "KHR_materials_sheen";
inline constexpr std::string_view kSpecular = "KHR_materials_specular";
inline constexpr std::string_view kTransmission = "KHR_materials_transmission";
inline constexpr std::string_view kUnlit = "KHR_materials_unlit";
inline constexpr std::string_view kVolume = "KHR_materials_volume";
inline constexpr std::string_view kDisney = "ALAB_materials_disney";

}  // namespace alabaster::hd::gltf
