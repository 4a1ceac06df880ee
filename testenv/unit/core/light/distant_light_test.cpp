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

}  // namespace
}  // namespace alabaster
