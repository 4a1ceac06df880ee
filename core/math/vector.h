// Vectors are Imath's, the type that the whole field exchanges. This header adds the few free functions that read
// better than Imath's operators. Row vectors throughout: p' = p * M.
#pragma once

#include <ImathMatrix.h>
#include <ImathVec.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace alabaster {

using Vec2f = Imath::V2f;
using Vec2i = Imath::V2i;
using Vec3f = Imath::V3f;
using Vec3d = Imath::V3d;
using Vec3i = Imath::V3i;
using Vec4f = Imath::V4f;
using Matrix4d = Imath::M44d;

inline constexpr double kPiDouble = std::numbers::pi;
inline constexpr float kPi = std::numbers::pi_v<float>;
inline constexpr float kInvPi = std::numbers::inv_pi_v<float>;
inline constexpr float kTwoPi = 2 * kPi;
/// The largest float below one: random numbers lie in [0, kOneMinusEpsilon].
inline constexpr float kOneMinusEpsilon = 0x1.fffffep-1f;

template <class T>
T dot(const Imath::Vec3<T>& a, const Imath::Vec3<T>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class T>
Imath::Vec3<T> cross(const Imath::Vec3<T>& a, const Imath::Vec3<T>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class T>
T length(const Imath::Vec3<T>& v) {
  return std::sqrt(dot(v, v));
}
/// Unit vector along v; v must be non-zero and its squared length representable.
template <class T>
Imath::Vec3<T> normalize(const Imath::Vec3<T>& v) {
  return v * (T(1) / length(v));
}
inline float max_component(const Vec3f& v) {
  return std::max(v.x, std::max(v.y, v.z));
}
inline float max_abs_component(const Vec3f& v) {
  return std::max(std::abs(v.x), std::max(std::abs(v.y), std::abs(v.z)));
}
inline bool is_finite(const Vec3f& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}
inline float sqr(float x) {
  return x * x;
}
inline float lerp(float a, float b, float t) {
  return a + (b - a) * t;
}

}  // namespace alabaster
