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

}  // namespace
}  // namespace alabaster
