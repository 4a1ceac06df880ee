// Sheen of cloth: sheen * lerp(1, tint, sheenTint) * (1 - cos(theta_d))^5 (Burley 2012, section 5.7). No 1/pi: as
// published. f has no cosine; pdf per solid angle. Reciprocal. An addition on top of the diffuse lobe that is not
// compensated there: at most 0.089 sheen at grazing view for a white tint.
#pragma once

#include "core/material/bsdf_value.h"
#include "core/material/fresnel.h"
#include "core/sampling/warp.h"

namespace alabaster {

struct DisneySheen {
  Rgb color{0.0f};

  LobeValue evaluate(const Vec3f& wo, const Vec3f& wi) const {
    if (!(wo.z > 0 && wi.z > 0)) return {};
    return {color * schlick_weight(safe_sqrt(0.5f * (1 + dot(wo, wi)))), pdf_cosine_hemisphere(wi)};
  }
  std::optional<Vec3f> sample(const Vec3f&, const Vec2f& u) const { return sample_cosine_hemisphere(u); }

  /// Estimate of the directional albedo, within a factor of two: it falls from 0.088 at grazing view to 0.00026 at
  /// normal view.
  Rgb albedo(const Vec3f& wo) const { return color * (0.088f * sqr(1 - wo.z) + 3e-4f); }
};

}  // namespace alabaster
