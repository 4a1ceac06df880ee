// Orthonormal frames: local z is the normal.
#pragma once

#include "core/math/vector.h"

namespace alabaster {

/// Right-handed orthonormal basis; to_local / to_world keep lengths.
struct Frame {
  Vec3f s{1, 0, 0}, t{0, 1, 0}, n{0, 0, 1};

  Vec3f to_local(const Vec3f& v) const { return {dot(v, s), dot(v, t), dot(v, n)}; }
  Vec3f to_world(const Vec3f& v) const { return s * v.x + t * v.y + n * v.z; }
};

/// Any frame about unit n (Duff et al. 2017, "Building an Orthonormal Basis, Revisited").
inline Frame frame_from_normal(const Vec3f& n) {
  const float sign = std::copysign(1.0f, n.z);
  const float a = -1.0f / (sign + n.z);
  const float b = n.x * n.y * a;
  return {{1 + sign * n.x * n.x * a, sign * b, -sign * n.x}, {b, sign + n.y * n.y * a, -n.y}, n};
}

/// Frame about unit n whose s lies as near to `tangent` as it can; any frame if tangent is (nearly) along n or zero.
inline Frame frame_from_normal_tangent(const Vec3f& n, const Vec3f& tangent) {
  const Vec3f s = tangent - n * dot(n, tangent);
  const float l2 = dot(s, s);
  if (!(l2 > 1e-12f * dot(tangent, tangent))) return frame_from_normal(n);
  const Vec3f u = s * (1 / std::sqrt(l2));
  return {u, cross(n, u), n};
}

}  // namespace alabaster
