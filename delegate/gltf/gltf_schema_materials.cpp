#include <limits>

#include "core/material/disney_material.h"
#include "delegate/gltf/gltf_material_table.h"
#include "delegate/gltf/gltf_schema_parts.h"

namespace alabaster::hd::gltf {
namespace {

const Schema& texture_info_schema() {
  static const Schema transform{{numbers("offset", 2),
                                 {.name = "rotation", .kind = Kind::number},
                                 numbers("scale", 2),
                                 integer("texCoord", 0, 1000)},
                                {}};
  static const Schema schema{{reference("index", "textures", true),
                              integer("texCoord", 0, 1000),
                              {.name = "scale", .kind = Kind::number},
                              {.name = "strength", .kind = Kind::number}},
                             {object("KHR_texture_transform", transform)}};
  return schema;
}

Property texture(const char* name) {
  return object(name, texture_info_schema());
}

// A texture for each parameter of the surface; the material's translation checks everything else.
const Schema& disney_schema() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const MaterialParameter& parameter : material_parameters())
      all.push_back(std::string(parameter.name) + "Texture");
    return all;
  }();
  static const Schema schema = [] {
    Schema made;
    for (const std::string& name : names) made.properties.push_back(texture(name.c_str()));
    return made;
  }();
  return schema;
}

Property factor_of(const MaterialRow& row) {
  if (row.kind == FactorKind::number) return factor(row.factor.data(), row.low, row.high);
  return color(row.factor.data(), row.high, row.kind == FactorKind::color ? 3 : 4);
}

std::vector<Property> properties_of(std::string_view layer) {
  std::vector<Property> properties;
  for (const MaterialRow& row : material_rows()) {
    if (layer != row.layer) continue;
    if (!row.factor.empty()) properties.push_back(factor_of(row));
    const auto is_same = [&](const Property& known) { return std::string_view(known.name) == row.texture; };
    if (row.texture && std::none_of(properties.begin(), properties.end(), is_same))
      properties.push_back(texture(row.texture));
  }
  return properties;
}

}  // namespace

std::span<const MaterialRow> material_rows() {
  constexpr double kLimit = std::numeric_limits<float>::max(), kTiny = std::numeric_limits<double>::min();
  constexpr FactorKind number = FactorKind::number, color = FactorKind::color, color_alpha = FactorKind::color_alpha;
  const Reading colors = color_reading(), alpha = alpha_reading(), red = number_reading("r"),
                green = number_reading("g"), blue = number_reading("b");
  static const MaterialRow rows[] = {
      {"", "emissiveFactor", color, 0, 1, 0, "emissiveTexture"},
      {"", "alphaCutoff", number, 0, kLimit, 0.5},
      {"", "", number, 0, 0, 0, "normalTexture"},
      {"", "", number, 0, 0, 0, "occlusionTexture"},
      {kCore, "baseColorFactor", color_alpha, 0, 1, 1, "baseColorTexture"},
      {kCore, "metallicFactor", number, 0, 1, 1, "metallicRoughnessTexture", "metallic", blue},
      {kCore, "roughnessFactor", number, 0, 1, 1, "metallicRoughnessTexture", "roughness", green},
      {kGlossiness, "diffuseFactor", color_alpha, 0, 1, 1, "diffuseTexture"},
      {kGlossiness, "specularFactor", color, 0, 1, 1, "specularGlossinessTexture"},
      {kGlossiness, "glossinessFactor", number, 0, 1, 1},
      {kEmissiveStrength, "emissiveStrength", number, 0, kLimit, 1},
      {kIor, "ior", number, 0, 1e3, 1.5},
      {kSpecular, "specularFactor", number, 0, 1, 1, "specularTexture", "specular", alpha},
      {kSpecular, "specularColorFactor", color, 0, kLimit, 1, "specularColorTexture", "specularColor", colors},
      {kAnisotropy, "anisotropyStrength", number, 0, 1, 0, "anisotropyTexture"},
      {kAnisotropy, "anisotropyRotation", number, -kLimit, kLimit},
      {kClearcoat, "clearcoatFactor", number, 0, 1, 0, "clearcoatTexture", "coat", red},
      {kClearcoat, "clearcoatRoughnessFactor", number, 0, 1, 0, "clearcoatRoughnessTexture", "coatRoughness", green},
      {kClearcoat, "", number, 0, 0, 0, "clearcoatNormalTexture"},
      {kSheen, "sheenColorFactor", color, 0, 1, 0, "sheenColorTexture", "sheenColor", colors},
      {kSheen, "sheenRoughnessFactor", number, 0, 1, 0, "sheenRoughnessTexture", "sheenRoughness", alpha},
      {kIridescence, "iridescenceFactor", number, 0, 1, 0, "iridescenceTexture", "iridescence", red},
      {kIridescence, "iridescenceIor", number, 1, 4, 1.3, nullptr, "iridescenceIor"},
      {kIridescence, "iridescenceThicknessMinimum", number, 0, kLimit, 100},
      {kIridescence, "iridescenceThicknessMaximum", number, 0, kLimit, 400, "iridescenceThicknessTexture"},
      {kTransmission, "transmissionFactor", number, 0, 1, 0, "transmissionTexture", "specTrans", red},
      {kDiffuse, "diffuseTransmissionFactor", number, 0, 1, 0, "diffuseTransmissionTexture", "diffTrans", alpha},
      {kDiffuse, "diffuseTransmissionColorFactor", color, 0, 1, 1, "diffuseTransmissionColorTexture", "diffTransColor",
       colors},
      {kVolume, "thicknessFactor", number, 0, kLimit, 0, "thicknessTexture"},
      {kVolume, "attenuationDistance", number, kTiny, kLimit},
      {kVolume, "attenuationColor", color, 0, 1, 1},
      {kScatter, "multiscatterColor", color},
      {kScatter, "multiscatterColorFactor", color, 0, 1, 0, "multiscatterColorTexture"},
      {kScatter, "scatterAnisotropy", number, -1, 1},
      {kDispersion, "dispersion", number, 0, 20},
  };
  return rows;
}

const Schema& material_schema() {
  static const Schema core{properties_of(kCore), {}};
  static const std::map<std::string_view, Schema> layers = [] {
    std::map<std::string_view, Schema> made;
    for (const MaterialRow& row : material_rows())
      if (row.layer.starts_with("KHR_")) made[row.layer].properties = properties_of(row.layer);
    return made;
  }();
  static const Schema schema = [] {
    Schema made{properties_of(""), {object(kUnlit.data(), kMarker), object(kDisney.data(), disney_schema())}};
    for (const auto& [layer, of_layer] : layers) made.extensions.push_back(object(layer.data(), of_layer));
    made.properties.push_back(text("name"));
    made.properties.push_back(object(kCore.data(), core));
    made.properties.push_back(text("alphaMode", "|OPAQUE|MASK|BLEND|"));
    made.properties.push_back({.name = "doubleSided", .kind = Kind::boolean});
    return made;
  }();
  return schema;
}

}  // namespace alabaster::hd::gltf
