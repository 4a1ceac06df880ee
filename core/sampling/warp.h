// Warps: sample(u) and pdf(value). Directions are unit, local z up; pdfs per solid angle.
// u in [0,1)^2; on the very edge of it a cosine-weighted direction may lie in the plane (pdf 0): check before dividing.
#pragma once

#include <array>

#include "core/math/vector.h"

namespace alabaster {

Vec2f sample_concentric_disk(const Vec2f& u);

inline float safe_sqrt(float x) {
  return std::sqrt(std::max(0.0f, x));
}

/// Cosine-weighted hemisphere about +z (Malley). The height is from how far the disk's point is from the rim, which u
/// tells: 1 - x^2 - y^2 cancels towards the horizon.
inline Vec3f sample_cosine_hemisphere(const Vec2f& u) {
  const Vec2f d = sample_concentric_disk(u);
  const float to_rim = 2 * std::min(std::min(u.x, 1 - u.x), std::min(u.y, 1 - u.y));
  return {d.x, d.y, safe_sqrt(to_rim * (2 - to_rim))};
}
inline float pdf_cosine_hemisphere(const Vec3f& w) {
  return w.z > 0 ? w.z * kInvPi : 0;
}

inline Vec3f sample_uniform_sphere(const Vec2f& u) {
  // r = sqrt(1 - z^2) without cancellation near the poles.
  const float z = 1 - 2 * u.x, r = 2 * safe_sqrt(u.x * (1 - u.x)), phi = kTwoPi * u.y;
  return {r * std::cos(phi), r * std::sin(phi), z};
}
inline float pdf_uniform_sphere() {
  return 0.25f * kInvPi;
}

/// Uniform in the cone of directions with cos(theta) >= cos_max; one_minus_cos_max is passed because 1 - cos_max
/// cancels for small cones.
Vec3f sample_uniform_cone(const Vec2f& u, float one_minus_cos_max);
inline float pdf_uniform_cone(float one_minus_cos_max) {
  return 1 / (kTwoPi * one_minus_cos_max);
}

/// Uniform barycentric coordinates (b0, b1) of a triangle; area measure 1/area.
Vec2f sample_uniform_triangle(const Vec2f& u);

/// A density over the unit square that is bilinear between its corners, in any unit: those of weights[0] and [1] lie at
/// y = 0. None is negative, and not all are 0.
struct BilinearDensity {
  std::array<float, 4> weights;

  Vec2f sample(const Vec2f& u) const;
  /// Integrates to 1.
  float pdf(const Vec2f& at) const {
    const auto& w = weights;
    const float lower = w[0] + (w[1] - w[0]) * at.x, upper = w[2] + (w[3] - w[2]) * at.x;
    return 4 * (lower + (upper - lower) * at.y) / ((w[0] + w[1]) + (w[2] + w[3]));
  }
};

}  // namespace alabaster
