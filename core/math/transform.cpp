#include "core/math/transform.h"

#include <algorithm>
#include <cmath>

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

float least_stretch(const Affine& map) {
  // Eigenvalues of the Gram matrix by Jacobi's rotations, in double.
  const Vec3d rows[3] = {{map.x.x, map.x.y, map.x.z}, {map.y.x, map.y.y, map.y.z}, {map.z.x, map.z.y, map.z.z}};
  double a[3][3];
  double largest = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      a[i][j] = dot(rows[i], rows[j]);
      largest = std::max(largest, std::abs(a[i][j]));
    }
  constexpr int kSweeps = 12;
  for (int sweep = 0; sweep < kSweeps; ++sweep)
    for (int p = 0; p < 2; ++p)
      for (int q = p + 1; q < 3; ++q) {
        if (a[p][q] == 0) continue;
        const double theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
        const double t = std::copysign(1.0, theta) / (std::abs(theta) + std::hypot(theta, 1.0));
        const double c = 1 / std::hypot(t, 1.0), s = t * c;
        for (int k = 0; k < 3; ++k) {
          const double kp = a[k][p], kq = a[k][q];
          a[k][p] = c * kp - s * kq;
          a[k][q] = s * kp + c * kq;
        }
        for (int k = 0; k < 3; ++k) {
          const double pk = a[p][k], qk = a[q][k];
          a[p][k] = c * pk - s * qk;
          a[q][k] = s * pk + c * qk;
        }
      }
  const double smallest = std::min(a[0][0], std::min(a[1][1], a[2][2])) - 1e-15 * largest;
  return smallest > 0 ? static_cast<float>(std::sqrt(smallest) * (1 - 0x1p-22)) : 0;
}

}  // namespace alabaster
