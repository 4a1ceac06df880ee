#include "core/convergence/pixel_group.h"

#include <gtest/gtest.h>

namespace alabaster {
namespace {

constexpr PixelRect kWindows[] = {{0, 0, 6, 4}, {-3, 5, 4, 10}, {1, 1, 2, 9}, {7, -2, 8, -1}};

// Every pixel is in exactly one group's image, at the place given by its coordinates.
TEST(PixelGroup, GroupsPartitionAnyWindow) {
  for (const PixelRect& window : kWindows) {
    const auto width = size_t(window.width());
    std::vector<PixelNoise> noise(width * size_t(window.height()));
    for (size_t i = 0; i < noise.size(); ++i) noise[i].samples = uint32_t(i);
    std::vector<int> met(noise.size());
    for (int g = 0; g < kPixelGroups; ++g) {
      const GroupImage image = group_image(window, noise, g);
      for (int y = 0; y < image.noise.height; ++y)
        for (int x = 0; x < image.noise.width; ++x) {
          const PixelNoise& pixel = image.noise.pixels[size_t(y) * size_t(image.noise.width) + size_t(x)];
          const int px = image.x0 + 2 * x, py = image.y0 + 2 * y;
          EXPECT_EQ(pixel_group(px, py), g);
          EXPECT_EQ(pixel.samples, uint32_t(size_t(py - window.y0) * width + size_t(px - window.x0)));
          ++met[pixel.samples];
        }
    }
    for (const int times : met) EXPECT_EQ(times, 1);
  }
}

// No group allocates its own samples, or those of the group that ends it.
TEST(PixelGroup, NoneAllocatesForItselfOrForTheGroupThatEndsIt) {
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
      EXPECT_EQ(normals[3 * i + 1], float(expected));
    }
}

}  // namespace
}  // namespace alabaster
