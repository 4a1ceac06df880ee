#include "core/math/transform.h"

namespace alabaster {

bool is_valid_affine(const Matrix4d& m) {
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j)
      if (!std::isfinite(m[i][j])) return false;
  if (m[0][3] != 0 || m[1][3] != 0 || m[2][3] != 0 || m[3][3] != 1) return false;
  return linear_determinant(m) != 0;
}

}  // namespace alabaster
