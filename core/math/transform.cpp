#include "core/math/transform.h"

namespace alabaster {
namespace {

bool linear_is_finite(const Affine& a) {
  return is_finite(a.x) && is_finite(a.y) && is_finite(a.z);
}

// The determinant is taken in double: that of a sound float map may be as small as 1e-100.
double linear_determinant(const Affine& a) {
  return dot(Vec3d(a.x), cross(Vec3d(a.y), Vec3d(a.z)));
}

}  // namespace

bool is_valid_affine(const Matrix4d& m) {
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j)
      if (!std::isfinite(m[i][j])) return false;
  if (m[0][3] != 0 || m[1][3] != 0 || m[2][3] != 0 || m[3][3] != 1) return false;
  const Affine narrowed = to_affine(m);
  if (!linear_is_finite(narrowed) || !is_finite(narrowed.t)) return false;
  if (linear_determinant(m) == 0 || linear_determinant(narrowed) == 0) return false;
  return linear_is_finite(to_affine(m.inverse()));
}

}  // namespace alabaster
