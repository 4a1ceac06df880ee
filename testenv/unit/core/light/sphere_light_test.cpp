#include "core/light/sphere_light.h"

#include <gtest/gtest.h>

namespace alabaster {
namespace {

LightParameters sphere() {
  LightParameters d;
  d.type = LightType::sphere;
  return d;
}

TEST(SphereLight, DistancesAreToTheNearSideOutsideAndTheFarSideInside) {
  const SphereLight light(sphere(), Vec3d(0, 0, -3));  // centre at z = 3
  const auto hit = light.intersect({{0, 0, 0}, {0, 0, 2}});
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->t, 1.25f, 1e-6f);
  EXPECT_FALSE(light.intersect({{0, 0, 0}, {0, 0, -1}}));
  EXPECT_FALSE(light.intersect({{0.6f, 0, 0}, {0, 0, 1}}));
  const auto inside = light.intersect({{0, 0, 3.25f}, {0, 0, -1}});
  ASSERT_TRUE(inside);
  EXPECT_NEAR(inside->t, 0.75f, 1e-6f);
  EXPECT_NEAR(inside->pdf, 1 / (4 * kPi), 1e-7f);
}

// pdf * solid angle = 1, and for small angles the solid angle is pi (r/d)^2 (1 + (r/d)^2/4 + ...): no cancellation.
TEST(SphereLight, FarSpheresKeepTheirPrecision) {
  LightParameters d = sphere();
  for (float ratio : {1e-2f, 1e-4f, 1e-8f, 1e-12f}) {
    d.radius = 100 * ratio;
    const auto s = SphereLight(d, Vec3d(0, 0, 0)).sample({0, 0, 100}, {0.5f, 0.5f});
    ASSERT_TRUE(s);
    const double q = static_cast<double>(ratio) * static_cast<double>(ratio);
    EXPECT_NEAR(s->pdf * kPiDouble * q * (1 + q / 4), 1, 1e-6) << ratio;
    EXPECT_NEAR(s->distance, 100 * (1 - ratio), 1);
  }
  // Just outside the surface: half of all directions.
  d.radius = 1;
  const auto s = SphereLight(d, Vec3d(0, 0, 0)).sample({0, 0, 1.0000001f}, {0.5f, 0.5f});
  ASSERT_TRUE(s);
  EXPECT_NEAR(s->pdf, 1 / (2 * kPi), 1e-3f);
}

// A normalised sphere of any radius has the radiant intensity pi r^2 L = I / 4 in each direction, and so has its limit.
TEST(SphereLight, NormalizedPointIsTheLimitOfANormalizedSphere) {
  LightParameters d = sphere();
  d.normalize = true;
  d.intensity = 8;
  d.radius = 1e-3f;
  const auto of_sphere = SphereLight(d, Vec3d(0, 0, 0)).sample({0, 0, -4}, {0.5f, 0.5f});
  ASSERT_TRUE(of_sphere);
  EXPECT_NEAR(of_sphere->radiance.g / of_sphere->pdf, 0.125f, 1e-6f);
  d.treat_as_point = true;
  EXPECT_EQ(SphereLight(d, Vec3d(0, 0, 0)).sample({0, 0, -4}, {0.5f, 0.5f})->radiance, Rgb(0.125f));
  d.treat_as_point = false;
  d.radius = 0;
  EXPECT_EQ(SphereLight(d, Vec3d(0, 0, 0)).sample({0, 0, -4}, {0.5f, 0.5f})->radiance, Rgb(0.125f));
}

}  // namespace
}  // namespace alabaster
