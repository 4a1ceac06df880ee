#include "core/convergence/pixel_group.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>

namespace alabaster {
namespace {

// Whatever the pattern of a picture, no group has more of it than chance gives: all 24 orders occur equally often, and
// those of neighbours are independent.
TEST(PixelGroup, OrderOfGroupsInABlockIsRandom) {
  constexpr int kSide = 120;
  std::map<std::array<int, 4>, int> orders;
  int equal = 0;
  const auto order_of = [](int x, int y) {
    return std::array{pixel_group(4 * x, 4 * y), pixel_group(4 * x + 2, 4 * y), pixel_group(4 * x, 4 * y + 2),
                      pixel_group(4 * x + 2, 4 * y + 2)};
  };
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) {
      ++orders[order_of(x, y)];
      equal += order_of(x, y) == order_of(x + 1, y) ? 1 : 0;
    }
  const double each = kSide * kSide / 24.0;  // 600 +- 24
  EXPECT_EQ(orders.size(), 24u);
  for (const auto& [order, times] : orders) EXPECT_NEAR(times, each, 4 * std::sqrt(each));
  EXPECT_NEAR(equal, each, 4 * std::sqrt(each));
}

// No group allocates its own samples, or those of the group that ends it.
TEST(PixelGroup, SamplesAreAllocatedByAnIndependentGroup) {
  for (int g = 0; g < kPixelGroups; ++g) {
    EXPECT_FALSE(allocates(g, g));
    EXPECT_NE(stopping_group(g), g);
    EXPECT_FALSE(allocates(g, stopping_group(g)));
  }
}

}  // namespace
}  // namespace alabaster
