#include "core/sampling/warp.h"

namespace alabaster {

// Shirley and Chiu 1997, "A Low Distortion Map Between Disk and Square".
Vec2f sample_concentric_disk(const Vec2f& u) {
  const float a = 2 * u.x - 1, b = 2 * u.y - 1;
  if (a == 0 && b == 0) return {0, 0};
  const bool a_major = std::abs(a) > std::abs(b);
  const float r = a_major ? a : b;
  const float phi = a_major ? 0.25f * kPi * (b / a) : 0.5f * kPi - 0.25f * kPi * (a / b);
  return {r * std::cos(phi), r * std::sin(phi)};
}

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

Vec2f invert_uniform_sphere(const Vec3f& w) {
  return {std::min(0.5f * one_minus_cos(w), 1.0f), azimuth01(w)};
}

Vec3f sample_uniform_cone(const Vec2f& u, float one_minus_cos_max) {
  const float one_minus_z = u.x * one_minus_cos_max;
  const float r = safe_sqrt(one_minus_z * (2 - one_minus_z)), phi = kTwoPi * u.y;
  return {r * std::cos(phi), r * std::sin(phi), 1 - one_minus_z};
}

Vec2f invert_uniform_cone(const Vec3f& w, float one_minus_cos_max) {
  return {std::min(one_minus_cos(w) / one_minus_cos_max, 1.0f), azimuth01(w)};
}

Vec2f sample_uniform_triangle(const Vec2f& u) {
  const float root = std::sqrt(u.x);
  return {1 - root, u.y * root};
}

Vec2f invert_uniform_triangle(const Vec2f& b) {
  const float root = 1 - b.x;
  return {root * root, root > 0 ? b.y / root : 0};
}

}  // namespace alabaster
