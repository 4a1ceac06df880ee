#include "core/session/tile_renderer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "testenv/support/scene_builder.h"

namespace alabaster {
namespace {

using testing::mixed_request;

// Off the origin, with the body's silhouette in it.
constexpr PixelRect kRect{24, 30, 44, 46};
constexpr size_t kPixels = 20 * 16;

bool always() {
  return true;
}

TileSamples samples_of(const SampleRange& range) {
  static const SampleAllocation uniform;
  return {kRect, range, uniform};
}

// All that a tile tells, as bytes.
std::vector<float> contents(const FilmTile& tile) {
  std::vector<float> all;
  for (size_t pixel = 0; pixel < kPixels; ++pixel) {
    for (const AovInfo& info : kAovs) {
      std::array<float, 4> value{};
      if (info.is_integer())
        value[0] = static_cast<float>(tile.resolve_int(pixel, info.aov));
      else
        tile.resolve(pixel, info.aov, value.data());
      all.insert(all.end(), value.begin(), value.end());
    }
    const PixelNoise noise = tile.noise(pixel);
    all.insert(all.end(), {noise.level, noise.latest, noise.previous, noise.earlier, noise.tail});
  }
  return all;
}

std::vector<float> render_ranges(const TileRenderer& renderer, const std::vector<SampleRange>& ranges) {
  FilmTile tile(kPixels, ~0u);
  RenderCounters counters;
  for (const SampleRange& range : ranges) EXPECT_TRUE(renderer.render(samples_of(range), always, &tile, &counters));
  EXPECT_EQ(counters.samples, ranges.back().end * kPixels);
  return contents(tile);
}

bool same_bytes(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

TEST(TileRenderer, SameTileAndRangeGiveTheSameBytes) {
  const RenderRequest request = mixed_request(8);
  const TileRenderer renderer(request), another(request);
  const auto first = render_ranges(renderer, {{0, 8}});
  EXPECT_TRUE(same_bytes(first, render_ranges(renderer, {{0, 8}})));
  EXPECT_TRUE(same_bytes(first, render_ranges(another, {{0, 8}})));
}

TEST(TileRenderer, ARangeInPiecesGivesTheSameBytes) {
  const RenderRequest request = mixed_request(8);
  const TileRenderer renderer(request);
  const auto whole = render_ranges(renderer, {{0, 8}});
  EXPECT_TRUE(same_bytes(whole, render_ranges(renderer, {{0, 4}, {4, 8}})));
  EXPECT_TRUE(same_bytes(whole, render_ranges(renderer, {{0, 1}, {1, 7}, {7, 8}})));
}

TEST(TileRenderer, ATileHoldsTheSamplesThatAreTracedOneByOne) {
  const RenderRequest request = mixed_request(1);
  const TileRenderer renderer(request);
  FilmTile tile(kPixels, request.aovs);
  RenderCounters counters;
  LightLayers layers;
  ASSERT_TRUE(renderer.render(samples_of({0, 1}), always, &tile, &counters));
  for (size_t pixel = 0; pixel < kPixels; pixel += 7) {
    const int x = kRect.x0 + static_cast<int>(pixel % 20), y = kRect.y0 + static_cast<int>(pixel / 20);
    const FilmSample sample = renderer.trace_sample({x, y, 0}, &counters, &layers);
    std::array<float, 4> color{}, diffuse{};
    tile.resolve(pixel, Aov::color, color.data());
    tile.resolve(pixel, Aov::diffuse, diffuse.data());
    EXPECT_EQ(Rgb(color[0], color[1], color[2]), sample.color);
    EXPECT_EQ(Rgb(diffuse[0], diffuse[1], diffuse[2]), layers.diffuse);
    EXPECT_EQ(tile.resolve_int(pixel, Aov::prim_id), sample.prim_id);
  }
}

TEST(TileRenderer, OnlyTheGroupsAskedForAreTracedAndTheirRaysCounted) {
  const RenderRequest request = mixed_request(2);
  FilmTile tile(kPixels, request.aovs);
  std::vector<uint32_t> rays(72 * 72);
  RenderCounters counters;
  TileSamples samples = samples_of({0, 2});
  samples.groups = 0b0110;
  samples.rays = &rays;
  ASSERT_TRUE(TileRenderer(request).render(samples, always, &tile, &counters));
  uint64_t sum = 0;
  for (int y = 0; y < 72; ++y)
    for (int x = 0; x < 72; ++x) {
      const uint32_t here = rays[static_cast<size_t>(72 * y + x)];
      const bool inside = x >= kRect.x0 && x < kRect.x1 && y >= kRect.y0 && y < kRect.y1;
      const bool traced = inside && (pixel_group(x, y) == 1 || pixel_group(x, y) == 2);
      EXPECT_EQ(here > 0, traced) << x << " " << y;
      if (inside) {
        EXPECT_EQ(tile.samples(static_cast<size_t>(20 * (y - kRect.y0) + x - kRect.x0)), traced ? 2u : 0u);
      }
      sum += here;
    }
  EXPECT_EQ(sum, counters.rays());
}

TEST(TileRenderer, EndsBeforeTheSampleThatIsRefused) {
  const RenderRequest request = mixed_request(4);
  FilmTile tile(kPixels, request.aovs);
  RenderCounters counters;
  int left = 10;
  EXPECT_FALSE(TileRenderer(request).render(
      samples_of({0, 4}), [&] { return left-- > 0; }, &tile, &counters));
  EXPECT_EQ(counters.samples, 10u);
}

}  // namespace
}  // namespace alabaster
