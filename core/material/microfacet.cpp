#include "core/material/microfacet.h"

#include "core/sampling/warp.h"

namespace alabaster {

Vec3f Ggx::sample(const Vec3f& wo, const Vec2f& u) const {
  // The hemisphere configuration of Heitz 2018, section 3.1: the view direction stretched, and a frame about it.
  const Vec3f v = normalize(Vec3f(alpha_x * wo.x, alpha_y * wo.y, wo.z));
  const float l2 = sqr(v.x) + sqr(v.y);
  const Vec3f t1 = l2 > 0 ? Vec3f(-v.y, v.x, 0) * (1 / std::sqrt(l2)) : Vec3f(1, 0, 0);
  const Vec3f t2 = cross(v, t1);
  // A point of the disk, half of which shrinks when it is seen from v, is projected onto the hemisphere.
  const float r = std::sqrt(u.x), phi = kTwoPi * u.y;
  const float p1 = r * std::cos(phi);
  const float p2 = lerp(safe_sqrt(1 - p1 * p1), r * std::sin(phi), 0.5f * (1 + v.z));
  const Vec3f n = t1 * p1 + t2 * p2 + v * safe_sqrt(1 - p1 * p1 - p2 * p2);
  // A normal of the horizon itself would have D = 0, and its sample no pdf.
  return normalize(Vec3f(alpha_x * n.x, alpha_y * n.y, std::max(1e-6f, n.z)));
}

Vec3f Gtr1::sample(const Vec2f& u) const {
  const float a2 = sqr(alpha);
  // sin^2 rather than cos^2: it is the small one.
  const float sin2 = std::clamp((std::pow(a2, 1 - u.x) - a2) / (1 - a2), 0.0f, 1.0f);
  const float r = std::sqrt(sin2), phi = kTwoPi * u.y;
  return {r * std::cos(phi), r * std::sin(phi), safe_sqrt(1 - sin2)};
}

}  // namespace alabaster
