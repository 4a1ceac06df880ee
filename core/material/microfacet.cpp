#include "core/material/microfacet.h"

#include "core/sampling/warp.h"

namespace alabaster {
namespace {

/// The hemisphere configuration of Heitz 2018, section 3.1: the view direction stretched, and a frame about it.
struct StretchedView {
  Vec3f v, t1, t2;
  float s;  // half of the disk that stays when it is seen from v

  StretchedView(const Ggx& ggx, const Vec3f& wo) {
    v = normalize(Vec3f(ggx.alpha_x * wo.x, ggx.alpha_y * wo.y, wo.z));
    const float l2 = sqr(v.x) + sqr(v.y);
    t1 = l2 > 0 ? Vec3f(-v.y, v.x, 0) * (1 / std::sqrt(l2)) : Vec3f(1, 0, 0);
    t2 = cross(v, t1);
    s = 0.5f * (1 + v.z);
  }
};

}  // namespace

Vec3f Ggx::sample(const Vec3f& wo, const Vec2f& u) const {
  const StretchedView view(*this, wo);
  const float r = std::sqrt(u.x), phi = kTwoPi * u.y;
  const float p1 = r * std::cos(phi);
  const float p2 = lerp(safe_sqrt(1 - p1 * p1), r * std::sin(phi), view.s);
  const Vec3f n = view.t1 * p1 + view.t2 * p2 + view.v * safe_sqrt(1 - p1 * p1 - p2 * p2);
  // A normal of the horizon itself would have D = 0, and its sample no pdf.
  return normalize(Vec3f(alpha_x * n.x, alpha_y * n.y, std::max(1e-6f, n.z)));
}

Vec2f Ggx::invert(const Vec3f& wo, const Vec3f& wm) const {
  const StretchedView view(*this, wo);
  const Vec3f n = normalize(Vec3f(wm.x / alpha_x, wm.y / alpha_y, wm.z));
  const float p1 = dot(n, view.t1);
  const float p2 = (dot(n, view.t2) - (1 - view.s) * safe_sqrt(1 - p1 * p1)) / view.s;
  const float azimuth = std::atan2(p2, p1) / kTwoPi;
  return {std::min(1.0f, p1 * p1 + p2 * p2), azimuth < 0 ? azimuth + 1 : azimuth};
}

Vec3f Gtr1::sample(const Vec2f& u) const {
  const float a2 = sqr(alpha);
  // sin^2 rather than cos^2: it is the small one.
  const float sin2 = std::clamp((std::pow(a2, 1 - u.x) - a2) / (1 - a2), 0.0f, 1.0f);
  const float r = std::sqrt(sin2), phi = kTwoPi * u.y;
  return {r * std::cos(phi), r * std::sin(phi), safe_sqrt(1 - sin2)};
}

Vec2f Gtr1::invert(const Vec3f& wm) const {
  const float a2 = sqr(alpha);
  const float sin2 = sqr(wm.x) + sqr(wm.y);
  const float azimuth = std::atan2(wm.y, wm.x) / kTwoPi;
  return {1 - std::log(sin2 * (1 - a2) + a2) / std::log(a2), azimuth < 0 ? azimuth + 1 : azimuth};
}

}  // namespace alabaster
