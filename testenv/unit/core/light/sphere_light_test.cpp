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

TEST(SphereLight, PointFallsOffWithTheSquareOfTheDistance) {
  LightParameters d = sphere();
  d.treat_as_point = true;
  d.intensity = 8;
  const SphereLight light(d, Vec3d(0, 0, 0));
  EXPECT_TRUE(light.is_delta());
  const auto s = light.sample({0, 0, -4}, {0.1f, 0.9f});
  ASSERT_TRUE(s);
  EXPECT_TRUE(s->delta);
  EXPECT_EQ(s->pdf, 1);
  EXPECT_EQ(s->distance, 4);
  EXPECT_EQ(s->radiance, Rgb(0.5f));
  EXPECT_FALSE(light.sample({0, 0, 0}, {0.1f, 0.9f}));
  EXPECT_FALSE(light.intersect({{0, 0, -4}, {0, 0, 1}}));
  EXPECT_NEAR(light.importance({0, 0, -4}), 0.5, 1e-7);
  d.treat_as_point = false;
  d.radius = 0;
  EXPECT_EQ(SphereLight(d, Vec3d(0, 0, 0)).sample({0, 0, -4}, {0, 0})->radiance, Rgb(0.5f));
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

TEST(SphereLight, NormalizeKeepsWhatItGives) {
  LightParameters d = sphere();
  d.normalize = true;
  d.light_to_world = Matrix4d(3, 0, 0, 0, 0, 3, 0, 0, 0, 0, 3, 0, 0, 0, 0, 1);
  for (float radius : {0.01f, 1.0f, 50.0f}) {
    d.radius = radius;
    // pi L (r / d)^2 with L = 1 / (4 pi r^2), wherever outside.
    EXPECT_NEAR(SphereLight(d, Vec3d(0, 0, 0)).importance({0, 0, 200}) * 160000, 1, 1e-5);
  }
  EXPECT_NEAR(SphereLight(sphere(), Vec3d(0, 0, 0)).importance({0.1f, 0.2f, 0.3f}), kPi, 1e-6) << "inside";
}

TEST(SphereLight, SpotTurnsWithTheLight) {
  LightParameters d = sphere();
  d.treat_as_point = true;
  d.cone_inner = 10;
  d.cone_outer = 20;
  d.light_to_world = Matrix4d(0, 0, -1, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1);  // local -z is world -x
  const SphereLight light(d, Vec3d(0, 0, 0));
  EXPECT_TRUE(light.sample({-2, 0, 0}, {0, 0}));
  EXPECT_FALSE(light.sample({2, 0, 0}, {0, 0}));
  EXPECT_FALSE(light.sample({0, 0, -2}, {0, 0}));
  EXPECT_GT(light.importance({-2, 0, 0}), 0);
  EXPECT_EQ(light.importance({2, 0, 0}), 0);
  EXPECT_EQ(light.importance({0, 0, -2}), 0);
}

// The cone's edge (20 degrees), widened by the sphere's extent (30 degrees at twice its radius).
TEST(SphereLight, ImportanceReachesAsFarAsTheSpotOfEveryPart) {
  LightParameters d = sphere();
  d.cone_inner = 10;
  d.cone_outer = 20;
  const SphereLight light(d, Vec3d(0, 0, 0));
  const auto at = [](double degrees) {
    const double a = degrees * kPiDouble / 180;
    return Vec3f(Vec3d(std::sin(a), 0, -std::cos(a)));
  };
  EXPECT_NEAR(light.importance(at(0)), kPi / 4, 1e-6);
  EXPECT_NEAR(light.importance(at(39)), kPi / 4, 1e-6) << "within the inner cone of some part";
  EXPECT_GT(light.importance(at(49.9)), 0);
  EXPECT_EQ(light.importance(at(50.1)), 0);
}

}  // namespace
}  // namespace alabaster
