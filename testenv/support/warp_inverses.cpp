#include "testenv/support/warp_inverses.h"

#include <algorithm>
#include <cmath>

namespace alabaster::testing {
namespace {

float azimuth01(const Vec3f& w) {
  const float phi = std::atan2(w.y, w.x) / kTwoPi;
  return phi < 0 ? std::min(phi + 1, kOneMinusEpsilon) : phi;
}
// 1 - cos, from the sine where the cosine cancels.
float one_minus_cos(const Vec3f& w) {
  return w.z > 0 ? (w.x * w.x + w.y * w.y) / (1 + w.z) : 1 - w.z;
}

}  // namespace

Vec2f invert_concentric_disk(const Vec2f& d) {
  const float r = std::sqrt(d.x * d.x + d.y * d.y);
  if (r == 0) return {0.5f, 0.5f};
  float phi = std::atan2(d.y, d.x);
  if (phi < -0.25f * kPi) phi += kTwoPi;
  float a, b;
  if (phi < 0.25f * kPi) {
    a = r;
    b = phi * a * 4 * kInvPi;
  } else if (phi < 0.75f * kPi) {
    b = r;
    a = -(phi - 0.5f * kPi) * b * 4 * kInvPi;
  } else if (phi < 1.25f * kPi) {
    a = -r;
    b = (phi - kPi) * a * 4 * kInvPi;
  } else {
    b = -r;
    a = -(phi - 1.5f * kPi) * b * 4 * kInvPi;
  }
  const auto unit = [](float x) { return std::clamp(0.5f * (x + 1), 0.0f, 1.0f); };
  return {unit(a), unit(b)};
}

Vec2f invert_uniform_sphere(const Vec3f& w) {
  return {std::min(0.5f * one_minus_cos(w), 1.0f), azimuth01(w)};
}

Vec2f invert_uniform_cone(const Vec3f& w, float one_minus_cos_max) {
  return {std::min(one_minus_cos(w) / one_minus_cos_max, 1.0f), azimuth01(w)};
}

Vec2f invert_uniform_triangle(const Vec2f& b) {
  const float root = 1 - b.x;
  return {root * root, root > 0 ? b.y / root : 0};
}

}  // namespace alabaster::testing
