#include "core/light/distant_light.h"

#include <gtest/gtest.h>

namespace alabaster {
namespace {

LightParameters distant(float angle) {
  LightParameters d;
  d.type = LightType::distant;
  d.angle = angle;
  return d;
}

TEST(DistantLight, ShinesAlongLocalMinusZ) {
  LightParameters d = distant(0);
  EXPECT_EQ(DistantLight(d, Vec3d(0, 0, 0)).sample({5, 6, 7}, {0, 0})->wi, Vec3f(0, 0, 1));
  d.light_to_world = Matrix4d(1, 0, 0, 0, 0, 0, 3, 0, 0, -3, 0, 0, 9, 9, 9, 1);  // local z is world -y
  const auto s = DistantLight(d, Vec3d(0, 0, 0)).sample({5, 6, 7}, {0, 0});
  EXPECT_EQ(s->wi, Vec3f(0, -1, 0));
  EXPECT_TRUE(s->delta);
  EXPECT_EQ(s->pdf, 1);
  EXPECT_TRUE(std::isinf(s->distance));
  EXPECT_EQ(s->radiance, Rgb(1.0f)) << "irradiance";
}

TEST(DistantLight, FillsItsConeExactly) {
  for (float angle : {0.53f, 10.0f, 170.0f, 190.0f, 350.0f}) {
    const DistantLight light(distant(angle), Vec3d(0, 0, 0));
    for (float factor : {0.999f, 1.001f}) {
      const double a = factor * angle / 2 * kPiDouble / 180;
      const Ray ray{{0, 0, 0}, Vec3f(Vec3d(std::sin(a), 0, std::cos(a)) * 3.0)};
      EXPECT_EQ(light.intersect(ray).has_value(), factor < 1) << angle;
    }
  }
  const DistantLight everywhere(distant(360), Vec3d(0, 0, 0));
  EXPECT_TRUE(everywhere.intersect({{0, 0, 0}, {1, 1, -3}}));
  EXPECT_NEAR(everywhere.sample({0, 0, 0}, {0.3f, 0.4f})->pdf, 1 / (4 * kPi), 1e-7f);
}

// UsdLux's size factors: pi sin^2, beyond a hemisphere pi (2 - sin^2).
TEST(DistantLight, NormalizeDividesByTheSizeFactor) {
  for (float angle : {0.53f, 90.0f, 180.0f, 240.0f}) {
    LightParameters d = distant(angle);
    d.normalize = true;
    const double s2 = std::pow(std::sin(angle * kPiDouble / 360), 2);
    const double factor = kPiDouble * (angle <= 180 ? s2 : 2 - s2);
    EXPECT_NEAR(DistantLight(d, Vec3d(0, 0, 0)).sample({0, 0, 0}, {0, 0})->radiance.r * factor, 1, 1e-6);
  }
}

// A cone too narrow for float directions is a delta light with the cone's irradiance.
TEST(DistantLight, VeryNarrowConesAreDeltas) {
  LightParameters d = distant(1e-6f);
  d.intensity = 1e16f;
  const DistantLight light(d, Vec3d(0, 0, 0));
  EXPECT_TRUE(light.is_delta());
  const double half = 0.5e-6 * kPiDouble / 180;
  EXPECT_NEAR(light.sample({0, 0, 0}, {0, 0})->radiance.r / (1e16 * kPiDouble * half * half), 1, 1e-5);
  EXPECT_FALSE(DistantLight(distant(1e-4f), Vec3d(0, 0, 0)).is_delta());
}

TEST(DistantLight, ImportanceIsTheIrradianceOfAFacingPlane) {
  const Vec3f p(1, 2, 3);
  EXPECT_NEAR(DistantLight(distant(0), Vec3d(0, 0, 0)).importance(p), 1, 1e-6);
  for (float angle : {0.53f, 30.0f, 180.0f}) {
    LightParameters d = distant(angle);
    d.normalize = true;
    EXPECT_NEAR(DistantLight(d, Vec3d(0, 0, 0)).importance(p), 1, 1e-5);
  }
  EXPECT_NEAR(DistantLight(distant(300), Vec3d(0, 0, 0)).importance(p), kPi, 1e-5) << "all of the hemisphere";
}

}  // namespace
}  // namespace alabaster
