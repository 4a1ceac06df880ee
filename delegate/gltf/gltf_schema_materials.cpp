#include "core/material/disney_material.h"
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

std::vector<Property> reflection_extensions() {
  static const Schema ior{{factor("ior", 0, kInfinity)}, {}};
  static const Schema specular{{factor("specularFactor", 0, 1), texture("specularTexture"),
                                color("specularColorFactor", kInfinity), texture("specularColorTexture")},
                               {}};
  static const Schema clearcoat{
      {factor("clearcoatFactor", 0, 1), texture("clearcoatTexture"), factor("clearcoatRoughnessFactor", 0, 1),
       texture("clearcoatRoughnessTexture"), texture("clearcoatNormalTexture")},
      {}};
  static const Schema sheen{{color("sheenColorFactor", 1), texture("sheenColorTexture"),
                             factor("sheenRoughnessFactor", 0, 1), texture("sheenRoughnessTexture")},
                            {}};
  static const Schema anisotropy{{factor("anisotropyStrength", 0, 1),
                                  {.name = "anisotropyRotation", .kind = Kind::number},
                                  texture("anisotropyTexture")},
                                 {}};
  static const Schema iridescence{
      {factor("iridescenceFactor", 0, 1), texture("iridescenceTexture"), factor("iridescenceIor", 1, kInfinity),
       factor("iridescenceThicknessMinimum", 0, kInfinity), factor("iridescenceThicknessMaximum", 0, kInfinity),
       texture("iridescenceThicknessTexture")},
      {}};
  static const Schema glossiness{{color("diffuseFactor", 1, 4), texture("diffuseTexture"), color("specularFactor", 1),
                                  factor("glossinessFactor", 0, 1), texture("specularGlossinessTexture")},
                                 {}};
  return {object("KHR_materials_ior", ior),
          object("KHR_materials_specular", specular),
          object("KHR_materials_clearcoat", clearcoat),
          object("KHR_materials_sheen", sheen),
          object("KHR_materials_anisotropy", anisotropy),
          object("KHR_materials_iridescence", iridescence),
          object("KHR_materials_pbrSpecularGlossiness", glossiness)};
}

std::vector<Property> other_extensions() {
  static const Schema strength{{factor("emissiveStrength", 0, kInfinity)}, {}};
  static const Schema transmission{{factor("transmissionFactor", 0, 1), texture("transmissionTexture")}, {}};
  static const Schema volume{
      {factor("thicknessFactor", 0, kInfinity), texture("thicknessTexture"),
       factor("attenuationDistance", std::numeric_limits<double>::min(), kInfinity), color("attenuationColor", 1)},
      {}};
  static const Schema scatter{{color("multiscatterColor", 1), color("multiscatterColorFactor", 1),
                               texture("multiscatterColorTexture"), factor("scatterAnisotropy", -1, 1)},
                              {}};
  static const Schema diffuse{{factor("diffuseTransmissionFactor", 0, 1), texture("diffuseTransmissionTexture"),
                               color("diffuseTransmissionColorFactor", 1), texture("diffuseTransmissionColorTexture")},
                              {}};
  static const Schema dispersion{{factor("dispersion", 0, kInfinity)}, {}};
  return {object("KHR_materials_emissive_strength", strength),
          object("KHR_materials_transmission", transmission),
          object("KHR_materials_volume", volume),
          object("KHR_materials_volume_scatter", scatter),
          object("KHR_materials_diffuse_transmission", diffuse),
          object("KHR_materials_dispersion", dispersion),
          object("KHR_materials_unlit", kMarker),
          object("ALAB_materials_disney", disney_schema())};
}

}  // namespace

const Schema& material_schema() {
  static const Schema pbr{{color("baseColorFactor", 1, 4), texture("baseColorTexture"), factor("metallicFactor", 0, 1),
                           factor("roughnessFactor", 0, 1), texture("metallicRoughnessTexture")},
                          {}};
  static const Schema schema = [] {
    Schema made{{text("name"),
                 object("pbrMetallicRoughness", pbr),
                 texture("normalTexture"),
                 texture("occlusionTexture"),
                 texture("emissiveTexture"),
                 color("emissiveFactor", 1),
                 text("alphaMode", "|OPAQUE|MASK|BLEND|"),
                 factor("alphaCutoff", 0, kInfinity),
                 {.name = "doubleSided", .kind = Kind::boolean}},
                reflection_extensions()};
    for (const Property& extension : other_extensions()) made.extensions.push_back(extension);
    return made;
  }();
  return schema;
}

}  // namespace alabaster::hd::gltf
