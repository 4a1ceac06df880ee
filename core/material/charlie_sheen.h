// Sheen of fibres as a layer with a roughness of its own, as KHR_materials_sheen defines it: colour D V with the
// "Charlie" distribution D = (2 + 1/alpha) sin(theta_m)^(1/alpha) / 2pi, alpha = roughness^2 (Estevez and Kulla 2017,
// "Production Friendly Microfacet Sheen BRDF"), and V = 1 / (4 (cos_o + cos_i - cos_o cos_i)) (Neubelt and Pettineo
// 2013, "Crafting a Next-Gen Material Pipeline for The Order: 1886"). f has no cosine; pdf per solid angle. Reciprocal.
#pragma once

#include "core/material/bsdf_value.h"
#include "core/material/microfacet.h"
#include "core/sampling/warp.h"

namespace alabaster {

/// Directional albedo of white sheen before it is limited: a table made at the first call in 0.2 s, exact to 1e-3, or
/// to 1e-3 of it where it is above 1. `place`: charlie_place() of the roughness.
float charlie_albedo(float cosine, float place);
/// A roughness, at least kMinRoughness, among the rows of that table: 0 to 1.
float charlie_place(float roughness);

struct CharlieSheen {
  static constexpr float kMinRoughness = 0.07f;  // below, the lobe is narrower than what a horizon resolves

  Rgb color{0.0f};
  float roughness = 0;  // 0: there is none
  float place = 0;      // charlie_place() of it

  static CharlieSheen from(const Rgb& color, float roughness) {
    const float resolved = std::max(kMinRoughness, roughness);
    return {color, resolved, charlie_place(resolved)};
  }

  /// D V of white. `sine2`: of the facet's angle, squared.
  float unlimited(const Vec3f& wo, const Vec3f& wi, float sine2) const {
    const float inverse = 1 / sqr(roughness);
    const float d = (2 + inverse) * std::pow(sine2, 0.5f * inverse) * (0.5f * kInvPi);
    return 0.25f * d / std::max(1e-6f, wo.z + wi.z - wo.z * wi.z);
  }
  /// D V reflects more than it receives at grazing view below roughness 0.4, up to 1.7 times; it is divided by that
  /// much. The pdf is uniform over the hemisphere, which bounds f cos / pdf by pi D.
  LobeValue evaluate(const Vec3f& wo, const Vec3f& wi) const {
    if (!(wo.z > 0 && wi.z > 0)) return {};
    const auto facet = mirror_facet(wo, wi);
    if (!facet) return {};
    const float excess = std::max({1.0f, charlie_albedo(wo.z, place), charlie_albedo(wi.z, place)});
    return {color * (unlimited(wo, wi, std::max(0.0f, 1 - sqr(facet->wm.z))) / excess), 0.5f * kInvPi};
  }
  std::optional<Vec3f> sample(const Vec3f&, const Vec2f& u) const {
    const float r = safe_sqrt(1 - sqr(u.x)), phi = kTwoPi * u.y;
    return Vec3f(r * std::cos(phi), r * std::sin(phi), u.x);
  }

  Rgb albedo(const Vec3f& wo) const { return color * std::min(1.0f, charlie_albedo(wo.z, place)); }
  /// The share that the layer leaves to those below (KHR_materials_sheen, "Albedo Scaling Technique").
  float passed(float cosine) const { return std::max(0.0f, 1 - max_component(color) * charlie_albedo(cosine, place)); }
  float over(float cos_o, float cos_i) const { return std::min(passed(cos_o), passed(cos_i)); }
};

}  // namespace alabaster
