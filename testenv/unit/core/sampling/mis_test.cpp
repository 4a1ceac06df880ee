#include "core/sampling/mis.h"

#include <gtest/gtest.h>

namespace alabaster {
namespace {

TEST(PowerHeuristic, WeightsAddToOneAndSurviveHugePdfs) {
  for (float a : {1e-30f, 0.5f, 1.0f, 3e38f})
    for (float b : {1e-30f, 0.25f, 2.0f, 3e38f})
      EXPECT_NEAR(power_heuristic(a, b) + power_heuristic(b, a), 1, 1e-6f) << a << ' ' << b;
  EXPECT_NEAR(power_heuristic(1, 2), 0.2f, 1e-7f);
  EXPECT_EQ(power_heuristic(1, 0), 1);
  EXPECT_EQ(power_heuristic(0, 1), 0);
  EXPECT_EQ(power_heuristic(0, 0), 0);
}

}  // namespace
}  // namespace alabaster
