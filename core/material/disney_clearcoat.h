// Clearcoat: 0.25 clearcoat F D G / (4 wo.z wi.z) with GTR1, Schlick at ior 1.5 (f0 = 0.04) and Smith GGX masking of
// fixed alpha 0.25 (Burley 2012, sections 5.4 to 5.6). f has no cosine; pdf per solid angle. Reciprocal. D and G do not
// belong together and the lobe is not taken off what lies beneath: its own albedo stays below 0.25 all the same.
#pragma once

#include "core/material/fresnel.h"
#include "core/material/microfacet.h"

namespace alabaster {

struct DisneyClearcoat {
  float strength = 0;  // the parameter `clearcoat`, in [0,1]
  Gtr1 gtr1;

  static DisneyClearcoat from(float clearcoat, float gloss) { return {clearcoat, {lerp(0.1f, 0.001f, gloss)}}; }

  Rgb eval(const Vec3f& wo, const Vec3f& wi) const {
    if (!(strength > 0 && wo.z > 0 && wi.z > 0)) return Rgb(0.0f);
    const auto facet = mirror_facet(wo, wi);
    if (!facet) return Rgb(0.0f);
    constexpr Ggx masking{0.25f, 0.25f};
    const float f = lerp(0.04f, 1.0f, schlick_weight(facet->cos_d));
    const float g_over_4_cos_cos = 0.25f * masking.g1_over_cos(wo) * masking.g1_over_cos(wi);
    return Rgb(0.25f * strength * f * gtr1.d(facet->wm) * g_over_4_cos_cos);
  }
  /// Normals by D wm.z, reflected: D wm.z / (4 wo.wm).
  float pdf(const Vec3f& wo, const Vec3f& wi) const {
    if (!(wo.z > 0 && wi.z > 0)) return 0;
    const auto facet = mirror_facet(wo, wi);
    return facet ? gtr1.pdf(facet->wm) / (4 * facet->cos_d) : 0;
  }
  /// Empty where the reflected direction goes below the horizon.
  std::optional<Vec3f> sample(const Vec3f& wo, const Vec2f& u) const {
    const Vec3f wm = gtr1.sample(u);
    if (!(dot(wo, wm) > 0)) return std::nullopt;
    const Vec3f wi = normalize(reflect_about(wo, wm));
    if (!(wi.z > 0)) return std::nullopt;
    return wi;
  }

  /// Estimate of the directional albedo: Fresnel at wo, at least its hemispherical mean, without masking.
  Rgb albedo(const Vec3f& wo) const {
    return Rgb(0.25f * strength * lerp(0.04f, 1.0f, std::max(schlick_weight(wo.z), 1.0f / 21)));
  }
};

}  // namespace alabaster
