#include "core/subsurface/henyey_greenstein.h"

#include <gtest/gtest.h>

#include "core/sampling/pixel_sampler.h"
#include "testenv/support/walk_pdfs.h"

namespace alabaster {
namespace {

constexpr float kAsymmetries[] = {-0.9f, -0.5f, -1e-3f, -1e-9f, 0.0f, 1e-9f, 1e-3f, 0.3f, 0.7f, 0.9f};
constexpr float kEdges[] = {0.0f, 0x1p-24f, 0.25f, 0.5f, 0.999f, kOneMinusEpsilon};

// cos = x + 3/2 g (1 - x^2) + O(g^2): the usual form has lost all digits of it long before g = 1e-7.
TEST(HenyeyGreenstein, SmallAsymmetriesDoNotCancel) {
  for (const float g : {-1e-4f, -1e-7f, 1e-12f, 1e-5f})
    for (const float u : kEdges) {
      const double x = 1 - 2 * static_cast<double>(u), d = g;
      const double expected = x + 1.5 * d * (1 - x * x);
      EXPECT_NEAR(sample_henyey_greenstein({u, 0.1f}, g).z, expected, 3e-7 + 4 * d * d) << g << ' ' << u;
    }
}

TEST(HenyeyGreenstein, IsUnitAndItsPolesDoNotCancel) {
  for (const float g : kAsymmetries) {
    for (const float u : kEdges)
      for (const float v : {0.0f, 0.3f, kOneMinusEpsilon})
        EXPECT_NEAR(length(sample_henyey_greenstein({u, v}, g)), 1, 5e-7f) << g << ' ' << u;
    // Near the poles sin^2 = 2 (1 -+ cos) is proportional to u: (1-g)^2/(1+g) 4u ahead, (1+g)^2/(1-g) 4u behind.
    const double u = 0x1p-24, d = g;
    const Vec3f ahead = sample_henyey_greenstein({0x1p-24f, 0.1f}, g);
    const Vec3f behind = sample_henyey_greenstein({1 - 0x1p-24f, 0.1f}, g);
    EXPECT_NEAR(std::hypot(ahead.x, ahead.y) / std::sqrt(4 * u * (1 - d) * (1 - d) / (1 + d)), 1, 2e-6) << g;
    EXPECT_NEAR(std::hypot(behind.x, behind.y) / std::sqrt(4 * u * (1 + d) * (1 + d) / (1 - d)), 1, 2e-6) << g;
  }
}

TEST(HenyeyGreenstein, DirectionsStayUnitOverAMillionScatterings) {
  for (const float g : {-0.9f, 0.5f, 0.9f}) {
    const HenyeyGreensteinPhase phase(g);
    Rng rng(3, 1);
    Vec3f direction(0, 0, 1);
    float worst = 0;
    for (int i = 0; i < 1000000; ++i) {
      const float u = rng.uniform();
      direction = phase.sample(direction, {u, rng.uniform()});
      worst = std::max(worst, std::abs(length(direction) - 1));
    }
    EXPECT_LT(worst, 4e-6f) << g;
  }
}

}  // namespace
}  // namespace alabaster
