// Specular reflection: anisotropic GGX with separable Smith masking, F D G1(wo) G1(wi) / (4 wo.z wi.z) (Burley 2012,
// section 5.4 and addendum; Burley 2015 uses alpha in G without the remapping of 2012).
// f has no cosine; pdf per solid angle. Reciprocal; energy <= 1, for f wi.z / pdf = F G1(wi) <= 1.
#pragma once

#include "core/material/bsdf_value.h"
#include "core/material/disney_parameters.h"
#include "core/material/fresnel.h"
#include "core/material/microfacet.h"
#include "core/material/thin_film.h"

namespace alabaster {

struct DisneySpecular {
  Rgb f0{0.0f}, f90{0.0f};
  Ggx ggx;
  ThinFilm film{};
  Rgb mean_dielectric{0.0f};  // Schlick's mean of the share that is no metal

  static DisneySpecular from(const DisneyParameters& p);

  /// The pdf is that of visible normals, reflected: D_v(wm) / (4 wo.wm), in which wo.wm cancels.
  LobeValue evaluate(const Vec3f& wo, const Vec3f& wi) const {
    if (!(wo.z > 0 && wi.z > 0)) return {};
    const auto facet = mirror_facet(wo, wi);
    if (!facet) return {};
    const float pdf = 0.25f * ggx.d(facet->wm) * ggx.g1_over_cos(wo);
    return {fresnel(facet->cos_d) * (pdf * ggx.g1_over_cos(wi)), pdf};
  }
  /// Empty where the reflected direction goes below the horizon: light that a further bounce between facets would
  /// carry.
  std::optional<Vec3f> sample(const Vec3f& wo, const Vec2f& u) const {
    const Vec3f wi = normalize(reflect_about(wo, ggx.sample(wo, u)));
    if (!(wi.z > 0)) return std::nullopt;
    return wi;
  }

  /// A film lies over the whole of what is reflected, and so do specular's f90 and its black.
  Rgb fresnel(float cosine) const {
    const Rgb bare = schlick(f0, f90, cosine);
    return film.share > 0 ? film.over(bare, cosine, f0, max_component(f90)) : bare;
  }

  /// Estimate of the directional albedo: Schlick at wo, but at least its hemispherical mean 1/21, which a rough facet
  /// sees even at normal view.
  Rgb albedo(const Vec3f& wo) const {
    const Rgb bare = lerp(f0, f90, std::max(schlick_weight(wo.z), 1.0f / 21));
    return film.share > 0 ? lerp(bare, fresnel(wo.z) + f90 * (1.0f / 21), film.share) : bare;
  }
};

/// Burley 2012, section 5.4: alpha = roughness^2, stretched to a ratio of at most 10.
inline Ggx disney_ggx(float roughness, float anisotropic) {
  const float aspect = anisotropic > 0 ? std::sqrt(1 - 0.9f * anisotropic) : 1, alpha = sqr(roughness);
  return {std::max(kMinAlpha, alpha / aspect), std::max(kMinAlpha, alpha * aspect)};
}

/// Schlick's f90 = 1 would leave a grazing reflection on a surface of ior 1, which has none: below f0 = 0.02 (ior 1.33)
/// f90 falls with f0 (Lagarde and de Rousiers 2014, "Moving Frostbite to PBR", section 3.1.3).
inline float f90_of(float f0) {
  return std::min(1.0f, 50 * f0);
}

/// Dielectric f0 by ior, tinted by base colour (specularTint) and by KHR_materials_specular:
/// f0 = min(1, f0_ior tint specularColor) specular, f90 = f90_of(f0_ior) specular; metallic blends to (baseColor, 1).
inline DisneySpecular DisneySpecular::from(const DisneyParameters& p) {
  const float f0_ior = f0_from_ior(p.ior);
  const Rgb white(1.0f);
  const Rgb tinted =
      (p.specular_tint > 0 ? lerp(white, tint(p.base_color), p.specular_tint) : white) * f0_ior * p.specular_color;
  // The clear share of the dielectric has a lobe of its own (disney_dielectric.h), or lies below this one.
  const float dielectric = p.is_transparent() ? p.specular : p.specular * (1 - p.spec_trans);
  const Rgb dielectric_f0 = clamp01(tinted) * dielectric;
  const Rgb dielectric_f90 = Rgb(dielectric * f90_of(f0_ior));
  DisneySpecular lobe;
  lobe.mean_dielectric = lerp(dielectric_f0, dielectric_f90, 1.0f / 21);
  lobe.f0 = lerp(dielectric_f0, p.base_color, p.metallic);
  lobe.f90 = lerp(dielectric_f90, Rgb(1.0f), p.metallic);
  lobe.ggx = disney_ggx(p.specular_roughness(), p.anisotropic);
  lobe.film = ThinFilm::of(p);
  return lobe;
}

}  // namespace alabaster
