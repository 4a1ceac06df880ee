// Affine maps. Matrix4d (row-vector, double) is the exchange form; Affine is the float form that inner loops use.
#pragma once

#include "core/math/vector.h"

namespace alabaster {

/// p' = p.x*x + p.y*y + p.z*z + t: the four rows of a row-vector affine matrix, in float.
struct Affine {
  Vec3f x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1}, t{0, 0, 0};

  bool operator==(const Affine&) const = default;
  Vec3f point(const Vec3f& p) const { return x * p.x + y * p.y + z * p.z + t; }
  Vec3f vector(const Vec3f& v) const { return x * v.x + y * v.y + z * v.z; }
  /// Applies the transpose of the linear part: with the inverse map this carries normals (unnormalised).
  Vec3f transpose_vector(const Vec3f& v) const { return {dot(x, v), dot(y, v), dot(z, v)}; }
};

inline Affine to_affine(const Matrix4d& m) {
  auto row = [&](int i) {
    return Vec3f(static_cast<float>(m[i][0]), static_cast<float>(m[i][1]), static_cast<float>(m[i][2]));
  };
  return {row(0), row(1), row(2), row(3)};
}

/// Determinant of the upper-left 3x3 part: negative for a map that mirrors.
inline double linear_determinant(const Matrix4d& m) {
  return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
         m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

inline Vec3d transform_point(const Vec3d& p, const Matrix4d& m) {
  return {p.x * m[0][0] + p.y * m[1][0] + p.z * m[2][0] + m[3][0],
          p.x * m[0][1] + p.y * m[1][1] + p.z * m[2][1] + m[3][1],
          p.x * m[0][2] + p.y * m[1][2] + p.z * m[2][2] + m[3][2]};
}
inline Vec3d transform_vector(const Vec3d& v, const Matrix4d& m) {
  return {v.x * m[0][0] + v.y * m[1][0] + v.z * m[2][0], v.x * m[0][1] + v.y * m[1][1] + v.z * m[2][1],
          v.x * m[0][2] + v.y * m[1][2] + v.z * m[2][2]};
}

/// True when every entry is finite, the last column is (0,0,0,1) and the linear part is invertible: in double and in
/// the float that inner loops use (a scale of 1e300 or 1e-60 is neither).
bool is_valid_affine(const Matrix4d& m);

/// The least factor by which a linear map stretches a vector: its smallest singular value, rounded down.
float least_stretch(const Affine& map);

}  // namespace alabaster
