#include "core/convergence/pixel_group.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <utility>

namespace alabaster {
namespace {

// A quad is in one group, and each block of 4 x 4 pixels has a quad of each, with negative coordinates, too.
TEST(PixelGroup, EachBlockHasAQuadOfEachGroup) {
  for (int y = -8; y < 8; y += 4)
    for (int x = -8; x < 8; x += 4) {
      uint32_t met = 0;
      for (int quad = 0; quad < 4; ++quad) {
        const int x0 = x + 2 * (quad & 1), y0 = y + (quad & 2), group = pixel_group(x0, y0);
        met |= 1u << group;
        for (const auto& [dx, dy] : {std::pair{1, 0}, {0, 1}, {1, 1}}) EXPECT_EQ(pixel_group(x0 + dx, y0 + dy), group);
      }
      EXPECT_EQ(met, kAllPixelGroups);
    }
}

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

TEST(PixelGroup, OnlyTheGroupsAskedForAreTaken) {
  const PixelRect window{-1, 0, 40, 35};
  Film from(window, aov_bit(Aov::normal)), to(window, aov_bit(Aov::normal));
  for (int t = 0; t < from.tile_count(); ++t) {
    FilmTile tile = from.load_tile(t);
    const PixelRect r = from.tile_rect(t);
    FilmSample sample;
    sample.normal = {0, 1, 0};
    for (size_t i = 0; i < size_t(r.width()) * size_t(r.height()); ++i) tile.add(i, sample);
    from.store_tile(t, tile);
  }
  copy_groups(from, 0b1001, &to);
  const auto samples = to.resolve_int(Aov::sample_count);
  const auto normals = to.resolve_float(Aov::normal);
  for (int y = 0; y < 35; ++y)
    for (int x = -1; x < 40; ++x) {
      const size_t i = size_t(y) * 41 + size_t(x + 1);
      const int expected = pixel_group(x, y) == 0 || pixel_group(x, y) == 3 ? 1 : 0;
      EXPECT_EQ(samples[i], expected);
      if (expected) {
        EXPECT_EQ(normals[3 * i + 1], 1);
      }
    }
}

}  // namespace
}  // namespace alabaster
