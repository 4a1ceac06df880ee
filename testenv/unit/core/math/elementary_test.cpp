#include "core/math/elementary.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace alabaster {
namespace {

TEST(QuickExp, IsRightToAFewUnitsOfTheLastPlace) {
  for (double x = -86.9; x < 88; x += 0.00137) {
    const auto argument = static_cast<float>(x);
    const double expected = std::exp(static_cast<double>(argument));
    ASSERT_NEAR(quick_exp(argument) / expected, 1, 2e-7) << argument;
  }
  EXPECT_EQ(quick_exp(0), 1);
  for (const float low : {-88.0f, -1e30f, -INFINITY}) EXPECT_EQ(quick_exp(low), 0);
}

TEST(QuickSineCosine, IsRightAllTheWayAround) {
  for (int i = 0; i <= 100000; ++i) {
    const float u = static_cast<float>(i) * 1e-5f;
    const double angle = 2 * std::numbers::pi * static_cast<double>(u);
    const SineCosine quick = quick_sine_cosine_turns(u);
    ASSERT_NEAR(quick.sine, std::sin(angle), 2e-7) << u;
    ASSERT_NEAR(quick.cosine, std::cos(angle), 2e-7) << u;
  }
}

}  // namespace
}  // namespace alabaster
