#include <algorithm>
#include <cmath>

#include "core/material/microfacet.h"
#include "delegate/gltf/gltf_material_parts.h"

namespace alabaster::hd::gltf {
namespace {

constexpr float kUnlimited = std::numeric_limits<float>::max();

}  // namespace

void set_dielectric(MaterialBuilder* material) {
  double ior = number_or(material->extension("KHR_materials_ior"), "ior", 1.5, 0, 1e3);
  Vec3f tint(1);
  if (ior == 0) tint = Vec3f(float(1 / 0.04));  // "reflects everything": f0 is specularColor itself
  if (ior > 0 && ior < 1)
    material->warn("material.ior", "extensions.KHR_materials_ior.ior",
                   "is below 1, which is not supported; 1.5 is used");
  if (ior < 1) ior = 1.5;
  material->set("ior", ior);
  const Extension specular = material->extension("KHR_materials_specular");
  if (specular) {
    material->set("specular", number_or(specular, "specularFactor", 1));
    material->connect("specular", use_in(specular, "specularTexture"), alpha_reading());
    tint *= color_or(specular, "specularColorFactor", Vec3f(1), kUnlimited);
    material->connect("specularColor", use_in(specular, "specularColorTexture"), color_reading());
  }
  if (specular || tint != Vec3f(1)) material->set("specularColor", tint);
}

void set_clearcoat(MaterialBuilder* material) {
  const Extension clearcoat = material->extension("KHR_materials_clearcoat");
  const double factor = number_or(clearcoat, "clearcoatFactor", 0);
  if (factor <= 0) return;
  material->set("coat", factor);
  material->connect("coat", use_in(clearcoat, "clearcoatTexture"), number_reading("r"));
  material->set("coatRoughness", number_or(clearcoat, "clearcoatRoughnessFactor", 0));
  material->connect("coatRoughness", use_in(clearcoat, "clearcoatRoughnessTexture"), number_reading("g"));
  const TextureUse normal = use_in(clearcoat, "clearcoatNormalTexture");
  material->connect("coatNormal", normal, normal_reading(normal.scale));
}

void set_sheen(MaterialBuilder* material) {
  const Extension sheen = material->extension("KHR_materials_sheen");
  const Vec3f color = color_or(sheen, "sheenColorFactor", Vec3f(0));
  if (color == Vec3f(0)) return;
  material->set("sheen", 1.0);
  material->set("sheenTint", 0.0);
  material->set("sheenColor", color);
  material->connect("sheenColor", use_in(sheen, "sheenColorTexture"), color_reading());
  // 0 would be Burley's sheen; the lobe itself ends at 0.07.
  material->set("sheenRoughness", std::max(0.07, number_or(sheen, "sheenRoughnessFactor", 0)));
  material->connect("sheenRoughness", use_in(sheen, "sheenRoughnessTexture"), alpha_reading());
}

void set_iridescence(MaterialBuilder* material) {
  const Extension film = material->extension("KHR_materials_iridescence");
  const double factor = number_or(film, "iridescenceFactor", 0);
  if (factor <= 0) return;
  material->set("iridescence", factor);
  material->connect("iridescence", use_in(film, "iridescenceTexture"), number_reading("r"));
  material->set("iridescenceIor", number_or(film, "iridescenceIor", 1.3, 1, 4));
  const auto least = float(number_or(film, "iridescenceThicknessMinimum", 100, 0, kUnlimited));
  const auto most = float(number_or(film, "iridescenceThicknessMaximum", 400, 0, kUnlimited));
  const TextureUse texture = use_in(film, "iridescenceThicknessTexture");
  material->set("iridescenceThickness", texture.index < 0 ? double(most) : 1.0);
  material->connect("iridescenceThickness", texture, {"g", "raw", Vec4f(most - least), Vec4f(least)});
}

// alpha_t = mix(alpha, 1, strength^2), alpha_b = alpha = roughness^2, from Disney's alpha_b / alpha_t = 1 - 0.9
// anisotropic and alpha_t alpha_b = roughness^4. A texture of strength x scales anisotropic, and roughness by 1 at x =
// 0 to the fourth root of alpha_t / alpha_b at x = 1, so that both ends are exact.
void set_anisotropy(MaterialBuilder* material) {
  const Extension anisotropy = material->extension("KHR_materials_anisotropy");
  const double strength = number_or(anisotropy, "anisotropyStrength", 0), roughness = material->number("roughness", 1);
  if (strength <= 0) return;
  const double b = std::max(roughness * roughness, double(kMinAlpha)), t = b + (1 - b) * strength * strength;
  const TextureUse texture = use_in(anisotropy, "anisotropyTexture");
  material->set("anisotropic", (1 - std::max(b / t, 1.1e-3)) / 0.9);
  material->connect("anisotropic", texture, number_reading("b"));
  material->set("roughness", std::pow(texture.index < 0 ? t * b : b * b, 0.25));
  material->connect("roughness", texture, {"b", "raw", Vec4f(float(std::pow(t / b, 0.25) - 1)), Vec4f(1)});
  const double turns = number_or(anisotropy, "anisotropyRotation", 0, -kUnlimited, kUnlimited) / (2 * M_PI);
  material->set("anisotropicRotation", texture.index < 0 ? turns - std::floor(turns) : 1.0);
  material->connect("anisotropicRotation", texture, {"direction", "raw", Vec4f(1), Vec4f(float(turns))});
}

}  // namespace alabaster::hd::gltf
