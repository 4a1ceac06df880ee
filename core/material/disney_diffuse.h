// Diffuse reflection of the Disney BSDF 2015 in its two parts (Burley 2015, section 3, "diffuse model refactoring"):
//
//   lambert  (1/pi)(1-.5F_L)(1-.5F_V)                       replaced by subsurface scattering
//   retro    (1/pi) R_R (F_L + F_V + F_L F_V (R_R - 1))     stays at the surface, R_R = 2 roughness cos^2(theta_d)
//
// F_x = (1 - cos x)^5. Their sum is Burley 2012's diffuse (1/pi)(1+(F_D90-1)F_L)(1+(F_D90-1)F_V), F_D90 = .5 + R_R.
// f has no cosine; pdf per solid angle. Reciprocal. The lambert part keeps energy. With the retro part white reflects
// 1.006 (roughness 0.5) and 1.036 (roughness 1) of a furnace seen head on, and at roughness 1 up to 1.5575 at grazing
// view: a property of the published model, which is not altered here.
#pragma once

#include <optional>

#include "core/material/bsdf_value.h"
#include "core/material/fresnel.h"
#include "core/sampling/warp.h"

namespace alabaster {

/// Attenuation of refraction through the surface, either way: 1 - .5 F.
inline float diffuse_transmittance(float cos_theta) {
  return 1 - 0.5f * schlick_weight(cos_theta);
}

/// The mean of diffuse_transmittance() over a cosine lobe: 2 Int_0^1 c (1-c)^5 dc = 1/21.
inline constexpr float kMeanDiffuseTransmittance = 41.0f / 42.0f;

struct DisneyDiffuse {
  Rgb lambert_color{0.0f};  // zero in a channel that scatters
  Rgb retro_color{0.0f};
  float roughness = 0;
  float flatness = 0;  // share of flat() in place of both

  /// The two parts without colour. wo.z, wi.z > 0.
  static float lambert(const Vec3f& wo, const Vec3f& wi) {
    return kInvPi * diffuse_transmittance(wo.z) * diffuse_transmittance(wi.z);
  }
  static float retro(const Vec3f& wo, const Vec3f& wi, float roughness) {
    const float fl = schlick_weight(wi.z), fv = schlick_weight(wo.z);
    // 2 cos^2(theta_d) = 1 + cos(2 theta_d).
    const float rr = roughness * std::clamp(1 + dot(wo, wi), 0.0f, 2.0f);
    // F_L + F_V - F_L F_V is a union of probabilities: never negative, so neither is the sum.
    return kInvPi * rr * (fl + fv * (1 - fl) + rr * fl * fv);
  }

  /// A medium's reflection by the profile of Hanrahan and Krueger 1993 (Burley 2012, section 5.3, `subsurface`),
  /// without colour. White reflects 0.75 of a furnace seen head on and, as published, up to 1.1 (roughness 0) and 1.6
  /// (roughness 1) at grazing view.
  static float flat(const Vec3f& wo, const Vec3f& wi, float roughness) {
    const float f90 = 0.5f * roughness * std::clamp(1 + dot(wo, wi), 0.0f, 2.0f);
    const float f = lerp(1.0f, f90, schlick_weight(wi.z)) * lerp(1.0f, f90, schlick_weight(wo.z));
    return kInvPi * 1.25f * (f * (1 / (wo.z + wi.z) - 0.5f) + 0.5f);
  }

  LobeValue evaluate(const Vec3f& wo, const Vec3f& wi) const {
    if (!(wo.z > 0 && wi.z > 0)) return {};
    LobeValue value{lambert_color * lambert(wo, wi) + retro_color * retro(wo, wi, roughness),
                    pdf_cosine_hemisphere(wi)};
    if (flatness > 0) value.f = lerp(value.f, retro_color * flat(wo, wi, roughness), flatness);
    return value;
  }
  std::optional<Vec3f> sample(const Vec3f&, const Vec2f& u) const { return sample_cosine_hemisphere(u); }

  /// Directional albedo, exact without flatness: Int f wi.z dwi.
  Rgb albedo(const Vec3f& wo) const {
    return lambert_color * lambert_albedo(wo.z) + retro_color * retro_albedo(wo.z, roughness);
  }
  /// (1-.5F_V)(1-1/42).
  static float lambert_albedo(float cos_o) { return diffuse_transmittance(cos_o) * kMeanDiffuseTransmittance; }
  static float retro_albedo(float cos_o, float roughness);
};

/// With wi.wo = co ci + so si cos(phi), the azimuthal means are <R_R> = r(1 + co ci) and
/// <R_R^2> = r^2((1 + co ci)^2 + so^2 si^2 / 2); the rest are moments M_n = 2 Int_0^1 c^n (1-c)^5 dc = 2 B(n+1, 6).
inline float DisneyDiffuse::retro_albedo(float cos_o, float roughness) {
  constexpr float m1 = 1.0f / 21, m2 = 1.0f / 84, m3 = 1.0f / 252;
  const float fv = schlick_weight(cos_o), c2 = sqr(cos_o);
  const float linear = (1 - fv) * (m1 + cos_o * m2) + fv * (1 + cos_o * (2.0f / 3));
  const float square = fv * (m1 + 2 * cos_o * m2 + c2 * m3 + 0.5f * (1 - c2) * (m1 - m3));
  return roughness * (linear + roughness * square);
}

}  // namespace alabaster
