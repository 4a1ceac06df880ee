#include "core/math/transform.h"

#include <gtest/gtest.h>

#include <limits>

namespace alabaster {
namespace {

Matrix4d scaled(double s) {
  Matrix4d m;
  m.setScale(s);
  return m;
}

TEST(Transform, AValidAffineMapIsInvertibleInDoubleAndInFloat) {
  EXPECT_TRUE(is_valid_affine(Matrix4d()));
  for (const double s : {1e-30, -1e-30, 1e-6, 1e6, 1e30}) EXPECT_TRUE(is_valid_affine(scaled(s))) << s;
  for (const double s : {0.0, 1e300, 1e39, 1e-39 * 1e-39, 1e-103, 1e-300})
    EXPECT_FALSE(is_valid_affine(scaled(s))) << s;
  Matrix4d flat;
  flat[2][2] = 1e-60;  // invertible in double only
  EXPECT_FALSE(is_valid_affine(flat));
  Matrix4d far;
  far[3][0] = 1e300;
  EXPECT_FALSE(is_valid_affine(far));
  far[3][0] = 1e30;
  EXPECT_TRUE(is_valid_affine(far));
  Matrix4d projective;
  projective[0][3] = 0.5;
  EXPECT_FALSE(is_valid_affine(projective));
  Matrix4d nan;
  nan[1][2] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(is_valid_affine(nan));
}

}  // namespace
}  // namespace alabaster
