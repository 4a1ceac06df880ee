#include "core/subsurface/lit_surface.h"

#include <gtest/gtest.h>

#include "core/sampling/pixel_sampler.h"
#include "core/sampling/warp.h"

namespace alabaster {
namespace {

/// Points of a sphere of that radius; `irradiance` of the outward normal.
template <class Irradiance>
std::vector<LitPoint> sphere(float radius, const Irradiance& irradiance) {
  std::vector<LitPoint> points;
  Rng rng(1, 1);
  for (int i = 0; i < 256; ++i) {
    const Vec3f n = sample_uniform_sphere({rng.uniform(), rng.uniform()});
    points.push_back({n * radius, -n, irradiance(n), 2 * kTwoPi * radius * radius / 256});
  }
  return points;
}

float sun(const Vec3f& n) {
  return std::max(0.0f, n.x);
}

TEST(LitSurface, LeadsThroughTheBodyToItsLitSide) {
  const auto lit = LitSurface::choose(sphere(1, sun));
  ASSERT_TRUE(lit);
  for (const float kappa : {0.0f, 1.0f, 3.0f}) {
    EXPECT_GT(lit->direction_from({-0.9f, 0, 0}, kappa).x, 0.6f) << kappa;
    EXPECT_NEAR(length(lit->direction_from({0, 0.9f, 0}, kappa)), 1, 1e-5);
  }
  // The steeper light falls off, the nearer is the light that counts.
  EXPECT_GT(lit->direction_from({0, 0.9f, 0}, 4).y, lit->direction_from({0, 0.9f, 0}, 0).y);
}

TEST(LitSurface, LightThatHardlyComesThroughLeadsNowhere) {
  const auto lit = LitSurface::choose(sphere(1, sun)),
             dim = LitSurface::choose(sphere(1, [](const Vec3f&n) { return 0x1p-20f * sun(n); }));
  ASSERT_TRUE(lit && dim);
  EXPECT_EQ(lit->direction_from({-0.9f, 0, 0}, 20), Vec3f(0, 0, 0));
  EXPECT_NE(lit->direction_from({0.9f, 0, 0}, 20), Vec3f(0, 0, 0)) << "near the light";
  // Only the share that comes through counts.
  EXPECT_EQ(dim->direction_from({-0.9f, 0, 0}, 3), lit->direction_from({-0.9f, 0, 0}, 3));
}

TEST(LitSurface, EvenLightAndDarknessHaveNone) {
  EXPECT_FALSE(LitSurface::choose(sphere(1, [](const Vec3f&) { return 0.7f; })));
  EXPECT_FALSE(LitSurface::choose(sphere(1, [](const Vec3f& n) { return 1 + 0.5f * n.z; })));
  EXPECT_FALSE(LitSurface::choose(sphere(1, [](const Vec3f&) { return 0.0f; })));
  EXPECT_FALSE(LitSurface::choose({}));
}

TEST(LitSurface, DirectionsAreFiniteAtExtremes) {
  for (const float radius : {1e-12f, 1.0f, 1e12f}) {
    const auto lit = LitSurface::choose(sphere(radius, sun));
    ASSERT_TRUE(lit) << radius;
    for (const float kappa : {0.0f, 1e-6f / radius, 1 / radius, 1e6f / radius})
      for (const Vec3f& p : {Vec3f(-0.9f, 0, 0), Vec3f(0, 0, 0), Vec3f(1, 0, 0)}) {
        const Vec3f direction = lit->direction_from(p * radius, kappa);
        const float size = length(direction);
        EXPECT_TRUE(size == 0 || std::abs(size - 1) < 1e-5f) << radius << " " << kappa << " " << size;
      }
  }
}

}  // namespace
}  // namespace alabaster
