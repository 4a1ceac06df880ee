#include "delegate/tradeoff/pareto.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace alabaster::tradeoff {
namespace {

using Indices = std::vector<size_t>;

TEST(Pareto, LeavesOutWhatIsBeaten) {
  const std::vector<CostError> points = {{4, 1}, {1, 8}, {2, 9}, {2, 3}, {3, 3.5}, {8, 1.5}};
  EXPECT_EQ(pareto_front(points), (Indices{1, 3, 0}));
}

TEST(Pareto, TiesAreBeatenInTheOtherMeasure) {
  const std::vector<CostError> points = {{2, 5}, {2, 4}, {1, 6}, {3, 4}, {0.5, 6}};
  EXPECT_EQ(pareto_front(points), (Indices{4, 1}));
}

TEST(Pareto, EqualPointsStandTogether) {
  const std::vector<CostError> points = {{2, 4}, {3, 9}, {2, 4}, {3, 9}, {1, 7}};
  EXPECT_EQ(pareto_front(points), (Indices{4, 0, 2}));
}

TEST(Pareto, NothingAndNonsense) {
  EXPECT_EQ(pareto_front({}), Indices{});
  const std::vector<CostError> points = {{NAN, 0}, {0, NAN}, {-INFINITY, 1}, {1, INFINITY}, {5, 5}};
  EXPECT_EQ(pareto_front(points), Indices{4});
}

TEST(Pareto, IsWhatTheDefinitionSays) {
  std::mt19937 random(7);
  std::vector<CostError> points(200);
  for (CostError& p : points) p = {double(random() % 30), double(random() % 30)};
  const Indices front = pareto_front(points);
  for (size_t i = 0; i < points.size(); ++i) {
    bool dominated = false;
    for (const CostError& other : points)
      dominated |= other.cost <= points[i].cost && other.error <= points[i].error &&
                   (other.cost < points[i].cost || other.error < points[i].error);
    EXPECT_EQ(std::count(front.begin(), front.end(), i), dominated ? 0 : 1) << i;
  }
}

}  // namespace
}  // namespace alabaster::tradeoff
