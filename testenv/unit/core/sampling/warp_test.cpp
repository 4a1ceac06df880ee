#include "core/sampling/warp.h"

#include <gtest/gtest.h>

#include "core/sampling/pixel_sampler.h"

namespace alabaster {
namespace {

// The sphere's caps stay resolved where 1 - cos cancels: u = 2^-24 is a ring of radius 2 sqrt(u).
TEST(Warp, PolesDoNotCancel) {
  for (float u : {0x1p-24f, 0x1p-20f, 0x1p-12f}) {
    const Vec3f w = sample_uniform_sphere({u, 0.125f});
    EXPECT_NEAR(std::hypot(w.x, w.y) / (2 * std::sqrt(u * (1 - u))), 1, 1e-6f);
    const Vec3f c = sample_uniform_cone({u, 0.125f}, 1e-6f);
    EXPECT_NEAR(std::hypot(c.x, c.y) / std::sqrt(2e-6f * u), 1, 1e-6f);
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
    }
}

}  // namespace
}  // namespace alabaster
