#include "delegate/tradeoff/pareto.h"

#include <gtest/gtest.h>

#include <cmath>

namespace alabaster::tradeoff {
namespace {

using Flags = std::vector<bool>;

/// noise^2 x cost is `work`, known to `share` of it.
CurvePoint point(size_t configuration, double cost, double work, double share = 0.05, Estimate bias = {}) {
  const double noise = work / cost;
  return {configuration, cost, {noise, noise * (1 - share), noise * (1 + share), noise * share / 2}, bias};
}

Estimate bias(double value, double low) {
  return {value, low, 2 * value - low, (value - low) / 1.96};
}

TEST(Front, EqualCurvesLeaveTheBaseAlone) {
  // The other is one per cent cheaper, which no interval tells.
  EXPECT_EQ(on_front(std::vector{point(0, 1, 1), point(0, 4, 1), point(1, 0.99, 1), point(1, 3.96, 1)}),
            (Flags{true, true, false, false}));
}

TEST(Front, ABetterCurveTakesTheBasesPlace) {
  EXPECT_EQ(on_front(std::vector{point(0, 1, 1), point(0, 4, 1), point(1, 1, 0.5), point(1, 4, 0.5)}),
            (Flags{false, false, true, true}));
}

TEST(Front, ABiasCountsWhereItIsCertain) {
  const auto flags = [](const Estimate& of_other) {
    return on_front(std::vector{point(0, 1, 1), point(0, 100, 1), point(1, 1, 0.3, 0.05, of_other),
                                point(1, 100, 0.3, 0.05, of_other)});
  };
  EXPECT_EQ(flags(bias(0.04, -0.01)), (Flags{false, false, true, true})) << "it may be 0";
  EXPECT_EQ(flags(bias(0.04, 0.03)), (Flags{false, true, true, false})) << "0.2 of error however long it takes";
}

TEST(Front, FirstOfTwoEquallyBetterCurvesIsChosen) {
  EXPECT_EQ(on_front(std::vector{point(0, 1, 1), point(1, 1, 0.5), point(2, 1, 0.49), point(3, 1, 0.3)}),
            (Flags{false, false, false, true}));
  EXPECT_EQ(on_front(std::vector{point(0, 1, 1), point(1, 1, 0.5), point(2, 1, 0.49)}), (Flags{false, true, false}));
}

TEST(Front, ADearerPointOfTheSameCurveMustBeBetter) {
  // A bright sample that only the longer render has met.
  EXPECT_EQ(on_front(std::vector{point(0, 1, 1), point(0, 4, 100)}), (Flags{true, false}));
}

TEST(Front, APointThatACheaperOneBeatsIsNoReasonToPreferAnother) {
  // At its cost the other errs as the base's cheaper point promises. A bright sample has spoilt the base's second
  // point.
  EXPECT_EQ(on_front(std::vector{point(0, 1, 1), point(0, 4, 100, 1), point(1, 3, 0.98)}), (Flags{true, false, false}));
  EXPECT_EQ(on_front(std::vector{point(0, 1, 1), point(0, 4, 100, 1), point(1, 3, 0.5)}), (Flags{false, false, true}));
}

TEST(Front, CurvesAreExtrapolatedByAFactorOfFourAtMost) {
  EXPECT_EQ(on_front(std::vector{point(0, 1, 1), point(1, 5, 2)}), (Flags{true, true}));
  EXPECT_EQ(on_front(std::vector{point(0, 1, 1), point(1, 3, 2)}), (Flags{true, false}));
}

TEST(Front, EmptyAndNonFinitePointsAreLeftOut) {
  EXPECT_EQ(on_front({}), Flags{});
  EXPECT_EQ(on_front(std::vector{point(0, NAN, 1), point(0, 0, 1), point(1, 1, NAN), point(2, 5, 5)}),
            (Flags{false, false, false, true}));
}

TEST(Front, AnErrorIsThatOfItsCurve) {
  const Estimate error = squared_error_at(point(0, 2, 1, 0.1, bias(0.04, 0.03)), 8);
  EXPECT_NEAR(error.value, 0.125 + 0.04, 1e-12);
  EXPECT_NEAR(error.low, 0.1125 + 0.03, 1e-12);
  EXPECT_NEAR(error.high, 0.1375 + 0.05, 1e-12);
}

}  // namespace
}  // namespace alabaster::tradeoff
