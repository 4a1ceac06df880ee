// The phase function of Henyey and Greenstein 1941: p = (1-g^2) / (4 pi (1 + g^2 - 2 g cos)^{3/2}), cos between the
// direction of travel before and after scattering, g its mean; per solid angle.
#pragma once

#include <cmath>

#include "core/math/elementary.h"
#include "core/math/frame.h"
#include "core/sampling/warp.h"

namespace alabaster {

/// Direction after scattering in a frame whose z is the direction before; unit. The usual inverse of the distribution
/// divides a vanishing difference by g. Here it is factored, v = 1 - u, q = (1+g) v + (1-g) u:
///   1 - cos = 2 (1-g)^2 u (1 + g v) / q^2,  1 + cos = 2 (1+g)^2 v (1 - g u) / q^2,
/// sums of positive terms, which neither divide by g nor cancel at any g or pole. g = 0 is sample_uniform_sphere, bit
/// for bit.
inline Vec3f sample_henyey_greenstein(const Vec2f& xi, float g) {
  const float u = xi.x, v = 1 - u, plus = 1 + g, minus = 1 - g;
  const float ahead = u + plus * v, behind = v + minus * u, scale = 1 / sqr(plus * v + minus * u);
  const float z = (sqr(plus) * v * behind - sqr(minus) * u * ahead) * scale;
  const float r = 2 * plus * minus * safe_sqrt(u * v * (ahead * behind)) * scale, phi = kTwoPi * xi.y;
  return {r * std::cos(phi), r * std::sin(phi), z};
}

/// Scattering in all directions alike.
struct IsotropicPhase {
  explicit IsotropicPhase(float) {}
  Vec3f sample(const Vec3f&, const Vec2f& u) const {
    const float z = 1 - 2 * u.x, r = 2 * safe_sqrt(u.x * (1 - u.x));
    const auto [sine, cosine] = quick_sine_cosine_turns(u.y);
    return {r * cosine, r * sine, z};
  }
};

struct HenyeyGreensteinPhase {
  float g;
  explicit HenyeyGreensteinPhase(float anisotropy) : g(anisotropy) {}
  /// `direction` of travel before scattering, unit, any frame; the same frame after.
  Vec3f sample(const Vec3f& direction, const Vec2f& u) const {
    return frame_from_normal(direction).to_world(sample_henyey_greenstein(u, g));
  }
};

}  // namespace alabaster
