#include "core/subsurface/half_space.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/subsurface/dwivedi.h"
#include "testenv/support/half_space.h"

namespace alabaster {
namespace {

double escape(double one_minus_alpha, double optical_depth) {
  return escape_probability(one_minus_alpha, dwivedi_mode(one_minus_alpha).x, optical_depth);
}

TEST(EscapeProbability, AtTheSurfaceAndWithoutAbsorptionIsInClosedForm) {
  for (const double complement : {0.0, 1e-6, 1e-3, 0.03, 0.2, 0.5, 0.8, 0.97, 1.0})
    EXPECT_NEAR(escape(complement, 0), 1 / (1 + std::sqrt(complement)), 4e-5) << complement;
  for (const double depth : {0.0, 1e-9, 0.1, 1.0, 30.0, 1e6, 1e30}) EXPECT_NEAR(escape(0, depth), 1, 1e-9) << depth;
}

// E_2(t) / 2, by its integral.
TEST(EscapeProbability, WithoutScatteringIsThatOfOneRay) {
  for (const double depth : {1e-5, 6e-5, 2e-4, 1e-3, 0.02, 0.3, 1.0, 4.0}) {
    constexpr int kSteps = 400000;
    double expected = 0;
    for (int i = 0; i < kSteps; ++i) expected += std::exp(-depth * kSteps / (i + 0.5)) / (2 * kSteps);
    EXPECT_NEAR(escape(1, depth), expected, depth < 3e-4 ? 2.5e-4 : 6e-5) << depth;
  }
}

// Int alpha J(t) exp(-t/mu) dt/mu = 1 - sqrt(1-alpha) H(mu), with the H function of another program.
TEST(EscapeProbability, HasTheDirectionalAlbedoAsItsLaplaceTransform) {
  for (const double complement : {1e-5, 1e-3, 0.02, 0.1, 0.35, 0.6, 0.9})
    for (const double mu : {0.05, 0.4, 1.0}) {
      // t = mu r^2 / (1-r)^2: the integrand is smooth where J grows like t log t.
      constexpr int kSteps = 20000;
      double sum = 0;
      for (int i = 0; i < kSteps; ++i) {
        const double r = (i + 0.5) / kSteps, root = r / (1 - r), t = root * root;
        sum += escape(complement, mu * t) * std::exp(-t) * 2 * root / ((1 - r) * (1 - r)) / kSteps;
      }
      const double expected = 1 - std::sqrt(complement) * testing::chandrasekhar_h(mu, complement);
      EXPECT_NEAR((1 - complement) * sum, expected, 1.5e-5) << complement << " " << mu;
    }
}

TEST(EscapeProbability, FallsWithDepthAndAbsorption) {
  double last_row = 2;
  for (int row = 0; row <= 64; ++row) {
    const double complement = row / 64.0;
    double last = 2, depth = 0;
    for (int i = 0; i < 140; ++i, depth = depth * 1.1 + 0.001) {
      const double now = escape(complement, depth);
      ASSERT_TRUE(now >= 0 && now <= 1 + 1e-9) << complement << " " << depth;
      EXPECT_LE(now, last + 1e-9) << complement << " " << depth;
      last = now;
    }
    EXPECT_LT(escape(complement, 0.7), last_row);
    last_row = escape(complement, 0.7);
  }
}

}  // namespace
}  // namespace alabaster
