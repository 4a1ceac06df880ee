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

Vec3f sample_uniform_cone(const Vec2f& u, float one_minus_cos_max) {
  const float one_minus_z = u.x * one_minus_cos_max;
  const float r = safe_sqrt(one_minus_z * (2 - one_minus_z)), phi = kTwoPi * u.y;
  return {r * std::cos(phi), r * std::sin(phi), 1 - one_minus_z};
}

Vec2f sample_uniform_triangle(const Vec2f& u) {
  const float root = std::sqrt(u.x);
  return {1 - root, u.y * root};
}

}  // namespace alabaster
