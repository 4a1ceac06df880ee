// Distributions of microfacet normals wm: D per projected area, so that Int D(wm) wm.z dwm = 1. All directions unit,
// local frame, z up.
#pragma once

#include <optional>

#include "core/math/vector.h"

namespace alabaster {

/// The sharpest GGX that is evaluated; roughness 0 becomes this. At 1e-4 the direction of a half vector in float (6e-8)
/// still resolves the lobe to a thousandth of its width, and D <= 1/(pi 1e-8) = 3.2e7 leaves room for every product.
inline constexpr float kMinAlpha = 1e-4f;

/// The facet that mirrors wo into wi. cos_d = wo.wm = wi.wm, taken as half the length of wo + wi: the same number
/// whichever direction is called wo, so that a lobe is reciprocal to the last bits.
struct MirrorFacet {
  Vec3f wm;
  float cos_d;
};

/// Empty if wo and wi are (nearly) opposite, where wm has no direction.
inline std::optional<MirrorFacet> mirror_facet(const Vec3f& wo, const Vec3f& wi) {
  const Vec3f sum = wo + wi;
  const float l2 = dot(sum, sum);
  if (!(l2 > 1e-30f)) return std::nullopt;
  const float l = std::sqrt(l2);
  return MirrorFacet{sum * (1 / l), 0.5f * l};
}

inline Vec3f reflect_about(const Vec3f& wo, const Vec3f& wm) {
  return wm * (2 * dot(wo, wm)) - wo;
}

/// Anisotropic GGX / Trowbridge-Reitz, Burley's GTR with exponent 2 (Burley 2012, appendix B.2, eq. 13).
struct Ggx {
  float alpha_x = 1, alpha_y = 1;  // >= kMinAlpha

  float d(const Vec3f& wm) const {
    if (!(wm.z > 0)) return 0;
    const float e = sqr(wm.x / alpha_x) + sqr(wm.y / alpha_y) + sqr(wm.z);
    return 1 / (kPi * alpha_x * alpha_y * e * e);
  }

  /// Smith's masking over the cosine, G1(w) / w.z, which stays finite where G1 alone would be divided by nothing:
  /// 2 / (cos + sqrt(cos^2 + (alpha_x x)^2 + (alpha_y y)^2)) (Burley 2012, section 5.6 and Walter et al. 2007, eq. 34).
  float g1_over_cos(const Vec3f& w) const {
    return 2 / (w.z + std::sqrt(sqr(w.z) + sqr(alpha_x * w.x) + sqr(alpha_y * w.y)));
  }

  /// A normal visible from wo, wo.z > 0. pdf per solid angle of wm: D(wm) G1(wo) max(0, wo.wm) / wo.z (Heitz 2018,
  /// "Sampling the GGX Distribution of Visible Normals", JCGT 7(4), eq. 3).
  Vec3f sample(const Vec3f& wo, const Vec2f& u) const;
};

/// GTR with exponent 1, isotropic: Berry's distribution, the long tail of the clearcoat (Burley 2012, appendix B.2,
/// eq. 4). 0 < alpha < 1.
struct Gtr1 {
  float alpha = 0.1f;

  float d(const Vec3f& wm) const {
    if (!(wm.z > 0)) return 0;
    const float a2 = sqr(alpha);
    // 1 + (a^2 - 1) cos^2 without the cancellation at the peak.
    const float t = sqr(wm.x) + sqr(wm.y) + a2 * sqr(wm.z);
    return (a2 - 1) / (kPi * std::log(a2) * t);
  }

  /// pdf per solid angle of wm: D(wm) wm.z. Burley 2012, appendix B.2, eq. 5: cos^2 = (1 - (a^2)^(1-u)) / (1 - a^2).
  Vec3f sample(const Vec2f& u) const;
};

}  // namespace alabaster
