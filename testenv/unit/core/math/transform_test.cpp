#include "core/math/transform.h"

#include <gtest/gtest.h>

#include "core/math/frame.h"
#include "core/sampling/pixel_sampler.h"
#include "core/sampling/warp.h"

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

TEST(LeastStretch, IsTheSmallestSingularValue) {
  Affine map;
  map.x = {3, 0, 0};
  map.y = {0, -0.25f, 0};
  map.z = {0, 0, 7};
  EXPECT_FLOAT_EQ(least_stretch(map), 0.25f);
  // Composed from its singular values: sum of s_k a_k b_k^T with two orthonormal frames.
  Rng rng(10, 9);
  for (int i = 0; i < 200; ++i) {
    const Frame a = frame_from_normal(sample_uniform_sphere({rng.uniform(), rng.uniform()}));
    const Frame b = frame_from_normal(sample_uniform_sphere({rng.uniform(), rng.uniform()}));
    const float s[3] = {0.01f + rng.uniform(), i % 2 ? 3.0f : 0.5f, (i % 3 ? -1.0f : 100.0f) * (1 + rng.uniform())};
    const auto row = [&](const Vec3f& axis) {
      return b.s * (s[0] * dot(axis, a.s)) + b.t * (s[1] * dot(axis, a.t)) + b.n * (s[2] * dot(axis, a.n));
    };
    map = {row({1, 0, 0}), row({0, 1, 0}), row({0, 0, 1}), {5, 6, 7}};
    const float smallest = std::min(std::abs(s[0]), std::min(std::abs(s[1]), std::abs(s[2])));
    EXPECT_NEAR(least_stretch(map) / smallest, 1, 3e-3) << s[0] << " " << s[1] << " " << s[2];
  }
  EXPECT_EQ(least_stretch({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}}), 0);
}

}  // namespace
}  // namespace alabaster
