#include <algorithm>

#include "delegate/gltf/gltf_material_parts.h"

namespace alabaster::hd::gltf {
namespace {

constexpr double kUnlimited = std::numeric_limits<float>::max();
constexpr double kF0 = 0.04;  // of ior 1.5

Extension specular_glossiness(const tinygltf::Material& material) {
  return find_extension(material, "KHR_materials_pbrSpecularGlossiness");
}

// KHR_materials_pbrSpecularGlossiness, in the dielectric with f0 = 0.04 specularColor and f90 = 1.
void set_specular_glossiness(Extension extension, MaterialBuilder* material) {
  const Vec3f specular = color_or(extension, "specularFactor", Vec3f(1));
  const TextureUse texture = use_in(extension, "specularGlossinessTexture");
  const double glossiness = number_or(extension, "glossinessFactor", 1);
  material->set("metallic", 0.0);
  material->set("specularColor", specular * float(1 / kF0));
  material->connect("specularColor", texture, color_reading());
  if (texture.index < 0) {
    material->set("baseColor", material->color("baseColor") * (1 - std::max({specular.x, specular.y, specular.z})));
    return material->set("roughness", 1 - glossiness);
  }
  material->set("roughness", 1.0);
  material->connect("roughness", texture, {"a", "sRGB", Vec4f(float(-glossiness)), Vec4f(1)});
}

void connect_base(const char* input, const BaseColor& base, const VertexColors& vertex, MaterialBuilder* material) {
  material->set(input, base.color);
  material->connect(input, base.texture, color_reading());
  if (vertex.colors) material->connect_primvar(input, "displayColor", "rgb");
}

}  // namespace

BaseColor base_color_of(const tinygltf::Material& material) {
  if (const Extension extension = specular_glossiness(material)) {
    const double alpha =
        extension->Has("diffuseFactor") ? extension->Get("diffuseFactor").Get(3).GetNumberAsDouble() : 1;
    return {color_or(extension, "diffuseFactor", Vec3f(1)), std::clamp(alpha, 0.0, 1.0),
            use_in(extension, "diffuseTexture")};
  }
  const auto& pbr = material.pbrMetallicRoughness;
  const double alpha = pbr.baseColorFactor.size() == 4 ? pbr.baseColorFactor[3] : 1;
  return {to_color(pbr.baseColorFactor, Vec3f(1)), std::clamp(alpha, 0.0, 1.0), use_of(pbr.baseColorTexture)};
}

void set_base(const BaseColor& base, const VertexColors& vertex, MaterialBuilder* material) {
  connect_base("baseColor", base, vertex, material);
  if (const Extension extension = specular_glossiness(material->material())) {
    set_specular_glossiness(extension, material);
  } else {
    const auto& pbr = material->material().pbrMetallicRoughness;
    const TextureUse texture = use_of(pbr.metallicRoughnessTexture);
    material->set("metallic", std::clamp(pbr.metallicFactor, 0.0, 1.0));
    material->connect("metallic", texture, number_reading("b"));
    material->set("roughness", std::clamp(pbr.roughnessFactor, 0.0, 1.0));
    material->connect("roughness", texture, number_reading("g"));
  }
  const TextureUse normal = use_of(material->material().normalTexture);
  material->connect("normal", normal, normal_reading(normal.scale));
}

// Nothing is reflected: ior 1 has no Fresnel reflection, and the base is black.
void set_unlit(const BaseColor& base, const VertexColors& vertex, MaterialBuilder* material) {
  material->set("baseColor", Vec3f(0));
  material->set("metallic", 0.0);
  material->set("roughness", 1.0);
  material->set("ior", 1.0);
  material->set("specular", 0.0);
  connect_base("emission", base, vertex, material);
}

void set_opacity(const BaseColor& base, const VertexColors& vertex, MaterialBuilder* material) {
  const tinygltf::Material& source = material->material();
  const bool mask = source.alphaMode == "MASK";
  if (source.alphaMode == "OPAQUE" || (mask && source.alphaCutoff <= 0)) return;
  if (mask && source.alphaCutoff > 1) return material->set("opacity", 0.0);
  if (base.alpha == 1 && base.texture.index < 0 && !vertex.alphas) return;
  material->set("opacity", base.alpha);
  material->connect("opacity", base.texture, alpha_reading());
  if (vertex.alphas) material->connect_primvar("opacity", "displayOpacity", "a");
  if (mask) material->set("opacityThreshold", source.alphaCutoff);
}

void set_emission(MaterialBuilder* material) {
  const Vec3f factor = to_color(material->material().emissiveFactor, Vec3f(0));
  if (factor == Vec3f(0)) return;
  const Extension strength = material->extension("KHR_materials_emissive_strength");
  material->set("emission", factor * float(number_or(strength, "emissiveStrength", 1, 0, kUnlimited)));
  material->connect("emission", use_of(material->material().emissiveTexture), color_reading());
}

}  // namespace alabaster::hd::gltf
