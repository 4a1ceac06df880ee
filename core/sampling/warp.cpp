#include "core/sampling/warp.h"

namespace alabaster {
namespace {

// By a density that is linear from a at 0 to b at 1. The root of its integral, without cancellation where a is near b
// (Pharr, Jakob, Humphreys 2023, section 2.3.2).
float sample_linear(float u, float a, float b) {
  const float root = std::sqrt(a * a + (b * b - a * a) * u);
  return a + root > 0 ? std::min(u * (a + b) / (a + root), kOneMinusEpsilon) : 0;
}

}  // namespace

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

Vec2f BilinearDensity::sample(const Vec2f& u) const {
  const auto& w = weights;
  const float y = sample_linear(u.y, w[0] + w[1], w[2] + w[3]);
  return {sample_linear(u.x, w[0] + (w[2] - w[0]) * y, w[1] + (w[3] - w[1]) * y), y};
}

}  // namespace alabaster
