// The layers of a glTF material whose rows do not say all (gltf_material_table.h). delegate/manual/gltf.md has the
// table of translations.
#include "delegate/gltf/gltf_material.h"

#include <algorithm>
#include <cmath>

#include "core/material/disney_material.h"
#include "core/material/microfacet.h"
#include "core/material/scatter_distance.h"
#include "delegate/gltf/gltf_material_builder.h"
#include "delegate/looks/formulas.h"
#include "delegate/support/nearest_name.h"

namespace alabaster::hd::gltf {
namespace {

// A material's base colour and opacity, whichever model has them.
struct BaseColor {
  Vec3f color{1};
  double alpha = 1;
  TextureUse texture;
};

BaseColor base_color_of(const MaterialBuilder& material) {
  const bool glossiness = material.has(kGlossiness);
  const std::string_view layer = glossiness ? kGlossiness : kCore;
  const char* factor = glossiness ? "diffuseFactor" : "baseColorFactor";
  const Json& components = at(material.layer(layer), factor);
  return {material.color(layer, factor), components.is_null() ? 1 : components[3].get<double>(),
          material.texture(layer, glossiness ? "diffuseTexture" : "baseColorTexture")};
}

void connect_base(const char* input, const BaseColor& base, const VertexColors& vertex, MaterialBuilder* material) {
  material->set(input, base.color);
  material->connect(input, base.texture, color_reading());
  if (vertex.colors) material->connect_primvar(input, "displayColor", "rgb");
}

// KHR_materials_pbrSpecularGlossiness, in the dielectric with f0 = 0.04 specularColor and f90 = 1.
void set_specular_glossiness(MaterialBuilder* material) {
  const Vec3f specular = material->color(kGlossiness, "specularFactor");
  const TextureUse texture = material->texture(kGlossiness, "specularGlossinessTexture");
  const double glossiness = material->number(kGlossiness, "glossinessFactor");
  material->set("metallic", 0.0);
  material->set("specularColor", specular * looks::kSpecularColorOfOne);
  material->connect("specularColor", texture, color_reading());
  if (texture.index < 0) {
    material->set("baseColor", material->color_set("baseColor") * (1 - std::max({specular.x, specular.y, specular.z})));
    return material->set("roughness", 1 - glossiness);
  }
  material->set("roughness", 1.0);
  material->connect("roughness", texture, {"a", "sRGB", Vec4f(float(-glossiness)), Vec4f(1)});
}

void set_base(const BaseColor& base, const VertexColors& vertex, MaterialBuilder* material) {
  connect_base("baseColor", base, vertex, material);
  if (material->has(kGlossiness))
    set_specular_glossiness(material);
  else
    material->emit(kCore);
  material->connect_normal("normal", material->texture("", "normalTexture"));
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
  const std::string mode = material->material().value("alphaMode", "OPAQUE");
  const double cutoff = material->number("", "alphaCutoff");
  const bool mask = mode == "MASK";
  if (mode == "OPAQUE" || (mask && cutoff <= 0)) return;
  if (mask && cutoff > 1) return material->set("opacity", 0.0);
  if (base.alpha == 1 && base.texture.index < 0 && !vertex.alphas) return;
  material->set("opacity", base.alpha);
  material->connect("opacity", base.texture, alpha_reading());
  if (vertex.alphas) material->connect_primvar("opacity", "displayOpacity", "a");
  if (mask) material->set("opacityThreshold", cutoff);
}

void set_emission(MaterialBuilder* material) {
  if (!material->has_weight("")) return;
  material->set("emission",
                material->color("", "emissiveFactor") * float(material->number(kEmissiveStrength, "emissiveStrength")));
  material->connect("emission", material->texture("", "emissiveTexture"), color_reading());
}

void set_dielectric(MaterialBuilder* material) {
  double ior = material->number(kIor, "ior");
  Vec3f tint(1);
  if (ior == 0) tint = Vec3f(looks::kSpecularColorOfOne);  // "reflects everything": f0 is specularColor itself
  if (ior > 0 && ior < 1)
    material->say(Severity::warning, "material.ior", "extensions.KHR_materials_ior.ior",
                  "is below 1, which is not supported; 1.5 is used");
  if (ior < 1) ior = 1.5;
  material->set("ior", ior);
  if (material->has(kSpecular)) {
    material->emit(kSpecular);
    tint *= material->color(kSpecular, "specularColorFactor");
  }
  if (material->has(kSpecular) || tint != Vec3f(1)) material->set("specularColor", tint);
}

// alpha_t = mix(alpha, 1, strength^2), alpha_b = alpha = roughness^2, from Disney's alpha_b / alpha_t = 1 - 0.9
// anisotropic and alpha_t alpha_b = roughness^4. A texture of strength x scales anisotropic, and roughness by 1 at x =
// 0 to the fourth root of alpha_t / alpha_b at x = 1, so that both ends are exact.
void set_anisotropy(MaterialBuilder* material) {
  if (!material->has_weight(kAnisotropy)) return;
  const double strength = material->number(kAnisotropy, "anisotropyStrength");
  const double roughness = material->number_set("roughness", 1);
  const double b = std::max(roughness * roughness, double(kMinAlpha)), t = b + (1 - b) * strength * strength;
  const TextureUse texture = material->texture(kAnisotropy, "anisotropyTexture");
  material->set("anisotropic", (1 - std::max(b / t, 1.1e-3)) / 0.9);
  material->connect("anisotropic", texture, number_reading("b"));
  material->set("roughness", std::pow(texture.index < 0 ? t * b : b * b, 0.25));
  material->connect("roughness", texture, {"b", "raw", Vec4f(float(std::pow(t / b, 0.25) - 1)), Vec4f(1)});
  const double turns = material->number(kAnisotropy, "anisotropyRotation") / (2 * M_PI);
  material->set("anisotropicRotation", texture.index < 0 ? turns - std::floor(turns) : 1.0);
  material->connect("anisotropicRotation", texture, {"direction", "raw", Vec4f(1), Vec4f(float(turns))});
}

void set_coats(MaterialBuilder* material) {
  if (material->has_weight(kClearcoat)) {
    material->emit(kClearcoat);
    material->connect_normal("coatNormal", material->texture(kClearcoat, "clearcoatNormalTexture"));
  }
  if (material->has_weight(kSheen)) {
    material->emit(kSheen);
    material->set("sheen", 1.0);
    material->set("sheenTint", 0.0);
    // 0 would be Burley's sheen; the lobe itself ends at 0.07.
    material->set("sheenRoughness",
                  std::max(double(looks::kLeastSheenRoughness), material->number(kSheen, "sheenRoughnessFactor")));
  }
  if (!material->has_weight(kIridescence)) return;
  material->emit(kIridescence);
  const auto least = float(material->number(kIridescence, "iridescenceThicknessMinimum"));
  const auto most = float(material->number(kIridescence, "iridescenceThicknessMaximum"));
  const TextureUse texture = material->texture(kIridescence, "iridescenceThicknessTexture");
  material->set("iridescenceThickness", texture.index < 0 ? double(most) : 1.0);
  material->connect("iridescenceThickness", texture, {"g", "raw", Vec4f(most - least), Vec4f(least)});
}

// True if the volume has an extinction, as scattering requires.
bool attenuates(const MaterialBuilder& material) {
  return float(material.number(kVolume, "attenuationDistance")) > 0 &&
         material.color(kVolume, "attenuationColor") != Vec3f(1);
}

bool scatters(const MaterialBuilder& material) {
  return material.has(kScatter) && attenuates(material);
}

// A surface without a volume is a sheet. Diffuse transmission into a scattering volume is the walk (set_scatter).
void set_transmission(MaterialBuilder* material) {
  const bool clear = material->has_weight(kTransmission), scattering = scatters(*material);
  const bool diffuse = !scattering && material->has_weight(kDiffuse);
  if (clear) material->emit(kTransmission);
  if (diffuse) {
    material->emit(kDiffuse);
    material->set("diffTrans", 2 * material->number(kDiffuse, "diffuseTransmissionFactor"));
  }
  if (!clear && !diffuse) return;
  if (!scattering && !material->has_weight(kVolume)) return material->set("thin", true);
  if (material->has_weight(kDispersion) && !scattering)
    material->set("dispersion", material->number(kDispersion, "dispersion"));
  // A solid takes the square root of its colour at each surface (Burley 2015), the extension the colour itself.
  if (material->number_set("specTrans", 0) == 1 && !material->connected("specTrans")) material->square("baseColor");
  if (!attenuates(*material) || scattering) return;
  material->set("attenuationColor", material->color(kVolume, "attenuationColor"));
  material->set("attenuationDistance", material->number(kVolume, "attenuationDistance"));
}

double set_scatter_anisotropy(MaterialBuilder* material) {
  const double authored = material->number(kScatter, "scatterAnisotropy"), g = std::clamp(authored, -0.9, 0.9);
  if (g != authored)
    material->say(Severity::warning, "material.scatter", "extensions.KHR_materials_volume_scatter.scatterAnisotropy",
                  "is outside -0.9 to 0.9; the nearest value is used");
  if (g != 0) material->set("scatterAnisotropy", g);
  return g;
}

// A volume of one colour behind an opaque wall becomes baseColor and scatterDistance, which users know to edit.
void set_scatter(MaterialBuilder* material) {
  if (!material->has(kScatter)) return;
  const std::string place = "extensions.KHR_materials_volume_scatter";
  if (!material->has(kVolume))
    return material->say(Severity::warning, "material.scatter", place,
                         "requires KHR_materials_volume; the surface is opaque");
  if (!attenuates(*material))
    return material->say(Severity::warning, "material.scatter", "extensions.KHR_materials_volume",
                         "has no extinction, which scattering requires; set attenuationDistance and attenuationColor");
  // The draft renamed the key; the later name takes precedence.
  const bool later = material->layer(kScatter).contains("multiscatterColorFactor");
  const Vec3f albedo = material->color(kScatter, later ? "multiscatterColorFactor" : "multiscatterColor");
  const Vec3f attenuation = material->color(kVolume, "attenuationColor");
  const double distance = material->number(kVolume, "attenuationDistance");
  const double g = set_scatter_anisotropy(material);
  const TextureUse texture = material->texture(kScatter, "multiscatterColorTexture");
  const bool has_own_color = texture.index >= 0 || material->has_weight(kTransmission);
  Vec3f lengths;
  for (int c = 0; c < 3; ++c) {
    const double path = looks::attenuation_path(double(attenuation[c]), distance);
    lengths[c] = float(has_own_color ? path : path / ((1 - g) * distance_scale(double(albedo[c]))));
  }
  if (has_own_color) {
    material->set("meanFreePath", lengths);
    material->set("subsurfaceColor", albedo);
    material->connect("subsurfaceColor", texture, color_reading());
  } else {
    if (material->connected("baseColor"))
      material->say(Severity::warning, "material.scatter", "pbrMetallicRoughness.baseColorTexture",
                    "is left out because the scattering volume has one colour");
    material->set("scatterDistance", lengths);
    material->set("baseColor", albedo);
    material->disconnect("baseColor");
  }
  if (!material->has(kDiffuse))
    material->say(Severity::info, "material.scatter", "",
                  "is drawn as a dense medium although it has no KHR_materials_diffuse_transmission");
}

std::string suggestion(const std::string& name) {
  std::vector<std::string> names;
  for (const MaterialParameter& parameter : material_parameters()) names.emplace_back(parameter.name);
  return support::DidYouMean(name, names, "; schemas/disney_material.json lists them");
}

// The parameter of "baseColorTexture"; empty for other keys.
std::string textured_parameter(const std::string& key) {
  constexpr std::string_view kEnd = "Texture";
  return key.size() > kEnd.size() && key.ends_with(kEnd) ? key.substr(0, key.size() - kEnd.size()) : "";
}

// The type that the value must have; null if it has that type and was set.
const char* set_value(const MaterialParameter& parameter, const Json& value, MaterialBuilder* material) {
  if (parameter.is_color()) {
    const bool good = value.is_array() && value.size() == 3 &&
                      std::all_of(value.begin(), value.end(), [](const Json& v) { return v.is_number(); });
    if (!good) return "must be three numbers";
    material->set(parameter.name, Vec3f(value[0].get<float>(), value[1].get<float>(), value[2].get<float>()));
  } else if (std::holds_alternative<bool DisneyParameters::*>(parameter.member)) {
    if (!value.is_boolean()) return "must be true or false";
    material->set(parameter.name, value.get<bool>());
  } else if (parameter.words[0]) {
    if (!value.is_string()) return "must be a word";
    material->set(parameter.name, value.get<std::string>().c_str());
  } else {
    if (!value.is_number()) return "must be a number";
    material->set(parameter.name, value.get<double>());
  }
  return nullptr;
}

// The constants of this extension replace those of the other extensions, its textures all that is connected to the same
// parameter.
void set_disney_extension(MaterialBuilder* material) {
  for (const auto& [key, value] : material->layer(kDisney).items()) {
    const std::string place = "extensions.ALAB_materials_disney." + key, textured = textured_parameter(key);
    const MaterialParameter* parameter = find_material_parameter(textured.empty() ? key : textured);
    if (!parameter || (!textured.empty() && !parameter->is_textured())) {
      material->say(Severity::error, "material.disney", place, "is not a parameter" + suggestion(key));
    } else if (!textured.empty()) {
      material->disconnect(parameter->name);
      material->connect(
          parameter->name, texture_in(material->layer(kDisney), key.c_str()),
          parameter->texels == Texels::colors ? color_reading() : number_reading(parameter->is_color() ? "rgb" : "r"));
    } else if (const char* fault = set_value(*parameter, value, material)) {
      material->say(Severity::error, "material.disney", place, fault + std::string("; correct the value"));
    }
  }
}

}  // namespace

MaterialNetwork translate_material(const Document& document, size_t index, const VertexColors& vertex, const Path& id,
                                   Report& report) {
  MaterialBuilder material(document, document.materials[index], id, element_name("materials", index), report);
  const BaseColor base = base_color_of(material);
  if (material.has(kUnlit)) {
    set_unlit(base, vertex, &material);
  } else {
    set_base(base, vertex, &material);
    set_emission(&material);
    set_dielectric(&material);
    set_anisotropy(&material);
    set_coats(&material);
    set_transmission(&material);
    set_scatter(&material);
  }
  set_opacity(base, vertex, &material);
  if (material.material().value("doubleSided", false)) material.set("sides", "both");
  set_disney_extension(&material);
  return material.finish();
}

}  // namespace alabaster::hd::gltf
