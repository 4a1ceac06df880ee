// Clearcoat: 0.25 clearcoat F D G / (4 wo.z wi.z) with GTR1, Schlick at ior 1.5 (f0 = 0.04) and Smith GGX masking of
// fixed alpha 0.25 (Burley 2012, sections 5.4 to 5.6). f has no cosine; pdf per solid angle. Reciprocal. D and G do not
// belong together, and the lobes beneath are not dimmed by it: its own albedo stays below 0.25 all the same.
#pragma once

#include "core/material/bsdf_value.h"
#include "core/material/fresnel.h"
#include "core/material/microfacet.h"

namespace alabaster {

struct DisneyClearcoat {
  float strength = 0;  // the parameter `clearcoat`, in [0,1]
  Gtr1 gtr1;

  /// `least_roughness`: DisneyParameters::least_roughness, as far as a gloss of 0 goes.
  static DisneyClearcoat from(float clearcoat, float gloss, float least_roughness = 0) {
    constexpr float kDullest = 0.1f;
    return {clearcoat, {std::max(lerp(kDullest, 0.001f, gloss), std::min(kDullest, sqr(least_roughness)))}};
  }

  /// The pdf is that of normals by D wm.z, reflected: D wm.z / (4 wo.wm).
  LobeValue evaluate(const Vec3f& wo, const Vec3f& wi) const {
    if (!(wo.z > 0 && wi.z > 0)) return {};
    const auto facet = mirror_facet(wo, wi);
    if (!facet) return {};
    constexpr Ggx masking{0.25f, 0.25f};
    const float fresnel = lerp(0.04f, 1.0f, schlick_weight(facet->cos_d)), d = gtr1.d(facet->wm);
    const float g_over_4_cos_cos = 0.25f * masking.g1_over_cos(wo) * masking.g1_over_cos(wi);
    return {Rgb(0.25f * strength * fresnel * d * g_over_4_cos_cos),
            d * std::max(0.0f, facet->wm.z) / (4 * facet->cos_d)};
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
