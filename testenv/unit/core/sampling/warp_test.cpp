#include "core/sampling/warp.h"

#include <gtest/gtest.h>

#include "core/sampling/pixel_sampler.h"
#include "testenv/support/warp_inverses.h"

namespace alabaster {
namespace {

using testing::invert_concentric_disk;
using testing::invert_cosine_hemisphere;
using testing::invert_uniform_cone;
using testing::invert_uniform_sphere;
using testing::invert_uniform_triangle;

template <class Warp, class Invert>
void expect_round_trip(const Warp& warp, const Invert& invert, float tolerance) {
  Rng rng(1, 2);
  for (int i = 0; i < 20000; ++i) {
    const float x = rng.uniform();
    const Vec2f u(x, rng.uniform()), back = invert(warp(u));
    ASSERT_NEAR(back.x, u.x, tolerance);
    // Azimuth 0 and 1 are one.
    const float apart = std::abs(back.y - u.y);
    ASSERT_LT(std::min(apart, 1 - apart), tolerance / std::max(1e-3f, u.x * (1 - u.x))) << u.x << ' ' << u.y;
  }
}

TEST(Warp, InverseUndoesSample) {
  expect_round_trip([](const Vec2f& u) { return sample_concentric_disk(u); }, invert_concentric_disk, 2e-6f);
  expect_round_trip([](const Vec2f& u) { return sample_cosine_hemisphere(u); }, invert_cosine_hemisphere, 2e-6f);
  expect_round_trip([](const Vec2f& u) { return sample_uniform_sphere(u); }, invert_uniform_sphere, 1e-6f);
  expect_round_trip([](const Vec2f& u) { return sample_uniform_triangle(u); }, invert_uniform_triangle, 2e-6f);
  for (float width : {1.9f, 0.5f, 1e-3f, 1e-7f})
    expect_round_trip([&](const Vec2f& u) { return sample_uniform_cone(u, width); },
                      [&](const Vec3f& w) { return invert_uniform_cone(w, width); }, 2e-6f);
}

// The sphere's caps stay resolved where 1 - cos cancels: u = 2^-24 is a ring of radius 2 sqrt(u).
TEST(Warp, PolesDoNotCancel) {
  for (float u : {0x1p-24f, 0x1p-20f, 0x1p-12f}) {
    const Vec3f w = sample_uniform_sphere({u, 0.125f});
    EXPECT_NEAR(std::hypot(w.x, w.y) / (2 * std::sqrt(u * (1 - u))), 1, 1e-6f);
    EXPECT_NEAR(invert_uniform_sphere(w).x / u, 1, 1e-6f);
    const Vec3f c = sample_uniform_cone({u, 0.125f}, 1e-6f);
    EXPECT_NEAR(invert_uniform_cone(c, 1e-6f).x / u, 1, 1e-6f);
  }
}

TEST(Warp, ResultsAreUnitAndInDomainOnTheEdges) {
  for (float x : {0.0f, 0x1p-24f, 0.5f, kOneMinusEpsilon})
    for (float y : {0.0f, 0x1p-24f, 0.5f, kOneMinusEpsilon}) {
      const Vec2f u(x, y);
      for (const Vec3f& w : {sample_cosine_hemisphere(u), sample_uniform_sphere(u), sample_uniform_cone(u, 0.2f),
                             sample_uniform_cone(u, 2.0f)}) {
        EXPECT_NEAR(length(w), 1, 3e-7f) << x << ' ' << y;
      }
      EXPECT_GE(sample_cosine_hemisphere(u).z, 0);
      const Vec2f d = sample_concentric_disk(u);
      EXPECT_LE(d.x * d.x + d.y * d.y, 1 + 3e-7f);
      const Vec2f b = sample_uniform_triangle(u);
      EXPECT_TRUE(b.x >= 0 && b.y >= 0 && b.x + b.y <= 1 + 1e-7f);
      for (const Vec2f& v : {invert_concentric_disk(d), invert_uniform_sphere(sample_uniform_sphere(u)),
                             invert_uniform_cone(sample_uniform_cone(u, 0.2f), 0.2f)}) {
        EXPECT_TRUE(v.x >= 0 && v.x <= 1 && v.y >= 0 && v.y <= 1) << x << ' ' << y;
      }
    }
  // Just below azimuth 0.
  EXPECT_LT(invert_uniform_sphere({1, -1e-30f, 0}).y, 1);
}

// Shirley and Chiu's map keeps area: small squares become patches of pi/4 of four times their area.
TEST(Warp, ConcentricDiskKeepsArea) {
  const float h = 1.0f / 512;
  for (float x = h; x < 1; x += 37 * h)
    for (float y = 3 * h; y < 1; y += 41 * h) {
      const Vec2f a = sample_concentric_disk({x, y});
      const Vec2f dx = sample_concentric_disk({x + h / 8, y}) - a, dy = sample_concentric_disk({x, y + h / 8}) - a;
      EXPECT_NEAR((dx.x * dy.y - dx.y * dy.x) / (h * h / 64), kPi, 0.03f) << x << ' ' << y;
    }
}

}  // namespace
}  // namespace alabaster
