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

TEST(QuickSineCosineDouble, IsRightAllTheWayAround) {
  for (int i = 0; i <= 100000; ++i) {
    const double angle = 2 * std::numbers::pi * 1e-5 * i;
    const SineCosineDouble quick = quick_sine_cosine(angle);
    ASSERT_NEAR(quick.sine, std::sin(angle), 1e-15) << angle;
    ASSERT_NEAR(quick.cosine, std::cos(angle), 1e-15) << angle;
  }
  for (double angle = 1e-12; angle < 0.7; angle *= 1.37)
    ASSERT_NEAR(quick_sine_cosine(angle).sine / std::sin(angle), 1, 1e-15) << angle;
}

TEST(QuickAtan2, IsRightAllTheWayAround) {
  for (int i = -100000; i <= 100000; ++i) {
    const double angle = std::numbers::pi * 1e-5 * i, radius = std::exp(0.0007 * i);
    const double x = radius * std::cos(angle), y = radius * std::sin(angle), expected = std::atan2(y, x);
    ASSERT_NEAR(quick_atan2(y, x), expected, 1e-15 * std::abs(expected)) << angle;
  }
  EXPECT_EQ(quick_atan2(0.0, 2.0), 0);
  EXPECT_NEAR(quick_atan2(3.0, 0.0), std::numbers::pi / 2, 1e-15);
}

}  // namespace
}  // namespace alabaster
