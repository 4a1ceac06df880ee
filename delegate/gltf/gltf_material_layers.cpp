#include <algorithm>
#include <cmath>

#include "core/material/fresnel.h"
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
  material->set("clearcoat", factor);
  material->connect("clearcoat", use_in(clearcoat, "clearcoatTexture"), number_reading("r"));
  const double roughness = number_or(clearcoat, "clearcoatRoughnessFactor", 0);
  material->set("clearcoatGloss", std::clamp((0.1 - roughness * roughness) / 0.099, 0.0, 1.0));
  const TextureUse normal = use_in(clearcoat, "clearcoatNormalTexture");
  material->connect("clearcoatNormal", normal, normal_reading(normal.scale));
}

void set_sheen(MaterialBuilder* material) {
  const Vec3f color = color_or(material->extension("KHR_materials_sheen"), "sheenColorFactor", Vec3f(0));
  const float sheen = std::max({color.x, color.y, color.z});
  if (sheen <= 0) return;
  // minimise |color / sheen - (white + t (hue - white))| over t in [0, 1], with the hue that the lobe mixes with
  const Vec3f base = material->color("baseColor");
  const Rgb hue = tint({base.x, base.y, base.z});
  const Vec3f colored = Vec3f(hue.r, hue.g, hue.b) - Vec3f(1), wanted = color / sheen - Vec3f(1);
  const float t = colored.length2() > 1e-8f ? colored.dot(wanted) / colored.length2() : 0.0f;
  material->set("sheen", double(sheen));
  material->set("sheenTint", double(std::clamp(t, 0.0f, 1.0f)));
}

// alpha_t = mix(alpha, 1, strength^2), alpha_b = alpha = roughness^2, from Disney's alpha_b / alpha_t = 1 - 0.9
// anisotropic and alpha_t alpha_b = roughness^4.
void set_anisotropy(MaterialBuilder* material) {
  const Extension anisotropy = material->extension("KHR_materials_anisotropy");
  const double strength = number_or(anisotropy, "anisotropyStrength", 0), roughness = material->number("roughness", 1);
  if (strength <= 0 || roughness <= 0) return;
  const double b = roughness * roughness, t = b + (1 - b) * strength * strength;
  const TextureUse texture = use_in(anisotropy, "anisotropyTexture");
  material->set("anisotropic", std::min(1.0, (1 - b / t) / 0.9));
  material->connect("anisotropic", texture, number_reading("b"));
  if (texture.index < 0) material->set("roughness", std::pow(t * b, 0.25));
}

}  // namespace alabaster::hd::gltf
