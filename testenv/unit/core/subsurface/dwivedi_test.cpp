#include "core/subsurface/dwivedi.h"

#include <gtest/gtest.h>

namespace alabaster {
namespace {

// The root of alpha theta = tanh(theta) by bisection, on the complement so that nothing cancels.
double bisected_theta(double complement) {
  long double low = 1e-9L, high = 1 / (1 - static_cast<long double>(complement)) + 1;
  for (int i = 0; i < 200; ++i) {
    const long double middle = (low + high) / 2;
    // tanh(t) - t by its series where it would cancel.
    const long double t2 = middle * middle;
    const long double excess =
        middle < 1e-2L ? -middle * t2 * (1 / 3.0L - t2 * (2 / 15.0L - t2 * (17 / 315.0L))) : std::tanh(middle) - middle;
    (excess + complement * middle > 0 ? low : high) = middle;
  }
  return static_cast<double>(low);
}

TEST(DwivediMode, SolvesCasesEquationFromBlackToWhite) {
  for (double complement = 1e-12; complement < 0.8; complement *= 1.07) {
    const DwivediMode mode = dwivedi_mode(complement);
    const double theta = bisected_theta(complement);
    EXPECT_NEAR(mode.x / std::tanh(theta), 1, 4e-7) << complement;
    EXPECT_NEAR(std::tanh(mode.theta) / mode.x, 1, 1e-12) << complement;
    EXPECT_NEAR(mode.alpha * mode.theta / mode.x, 1, 1e-12) << complement;
    EXPECT_NEAR(mode.alpha, 1 - complement, 1e-5);
  }
}

TEST(DwivediMode, EndsAreWhatTheyShouldBe) {
  EXPECT_EQ(dwivedi_mode(0).x, 0);
  EXPECT_EQ(dwivedi_mode(0).alpha, 1);
  EXPECT_EQ(dwivedi_mode(1).x, 1);
  for (const double complement : {0.9, 0.99, 0.9999, 1 - 1e-12}) {
    const DwivediMode mode = dwivedi_mode(complement);
    EXPECT_TRUE(mode.x > 0.9 && mode.x <= 1) << complement;
    EXPECT_TRUE(mode.theta > 0) << complement;
  }
  // Diffusion theory: kappa^2 -> 3 (1 - alpha).
  EXPECT_NEAR(dwivedi_mode(1e-10).x / std::sqrt(3e-10), 1, 4e-7);
}

TEST(ExponentialCosine, FactorsAreFiniteAndNormalisedWhateverTheReach) {
  for (const double x : {0.0, 1e-9, 1e-4, 1.0001e-4, 0.3, 5.0, 40.0, 700.0, 1e4, 1e30}) {
    EXPECT_TRUE(std::isfinite(x_over_sinh(x))) << x;
    for (const double mu : {-1.0, 0.0, 1.0}) {
      EXPECT_TRUE(std::isfinite(exponential_cosine_factor(mu, x))) << x;
      EXPECT_GE(exponential_cosine_factor(mu, x), 0) << x;
    }
    if (x > 100) continue;  // too narrow for the quadrature
    double integral = 0;
    constexpr int kPoints = 20000;
    for (int i = 0; i < kPoints; ++i) integral += exponential_cosine_factor(-1 + 2 * (i + 0.5) / kPoints, x) / kPoints;
    EXPECT_NEAR(integral, 1, 1e-6) << x;
  }
  EXPECT_EQ(x_over_sinh(0), 1);
  EXPECT_NEAR(x_over_sinh(1e-4), x_over_sinh(1.0001e-4), 1e-11);
  EXPECT_EQ(x_over_sinh(1e4), 0);
}

}  // namespace
}  // namespace alabaster
