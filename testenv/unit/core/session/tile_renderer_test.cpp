#include "core/session/tile_renderer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "testenv/support/same_bytes.h"
#include "testenv/support/scene_builder.h"

namespace alabaster {
namespace {

int32_t int_of(const FilmTile& tile, size_t pixel, Aov aov) {
  int32_t value = 0;
  tile.resolve_int(pixel, aov, &value);
  return value;
}

using testing::mixed_request;
using testing::same_bytes;

// Off the origin, with the body's silhouette in it.
constexpr PixelRect kRect{24, 30, 44, 46};
constexpr size_t kPixels = 20 * 16;

bool always() {
  return true;
}

TileSamples samples_of(const SamplePass& pass) {
  static const SampleAllocation uniform;
  return {kRect, pass, uniform};
}

// All that a tile tells, as bytes.
std::vector<float> contents(const FilmTile& tile) {
  std::vector<float> all;
  for (size_t pixel = 0; pixel < kPixels; ++pixel) {
    for (const AovInfo& info : kAovs) {
      std::array<float, 4> value{};
      if (info.is_integer())
        value[0] = static_cast<float>(int_of(tile, pixel, info.aov));
      else
        tile.resolve(pixel, info.aov, value.data());
      all.insert(all.end(), value.begin(), value.end());
    }
    const PixelNoise noise = tile.noise(pixel);
    all.insert(all.end(), {noise.level, noise.latest, noise.previous, noise.earlier, noise.tail});
  }
  return all;
}

TEST(TileRenderer, ExposureScalesRadianceAlone) {
  const RenderRequest request = mixed_request(1);
  RenderRequest exposed = request;
  exposed.camera.exposure = 3;
  const TileRenderer renderer(request), bright(exposed);
  RenderCounters counters;
  float most = 0;
  for (int y = kRect.y0; y < kRect.y1; y += 3)
    for (int x = kRect.x0; x < kRect.x1; x += 3) {
      LightLayers layers, bright_layers;
      const FilmSample plain = renderer.trace_sample({x, y, 0}, &counters, &layers);
      const FilmSample scaled = bright.trace_sample({x, y, 0}, &counters, &bright_layers);
      most = std::max(most, max_component(plain.color));
      EXPECT_EQ(scaled.color, plain.color * 8.0f);
      for (size_t i = 0; i < LightLayers::kParts; ++i) EXPECT_EQ(bright_layers.parts[i], layers.parts[i] * 8.0f);
      EXPECT_EQ(scaled.albedo, plain.albedo);
      EXPECT_EQ(scaled.alpha, plain.alpha);
      EXPECT_EQ(scaled.camera_depth, plain.camera_depth);
    }
  EXPECT_GT(most, 0);
}

TEST(TileRenderer, ExposureBeyondFloatsIsBlackAndCountedAsSuch) {
  RenderRequest request = mixed_request(1);
  request.camera.exposure = 140;
  const TileRenderer renderer(request);
  RenderCounters counters;
  LightLayers layers;
  EXPECT_EQ(renderer.trace_sample({kRect.x0, kRect.y0, 0}, &counters, &layers).color, Rgb(0.0f));
  EXPECT_EQ(counters.nonfinite_causes[size_t(NonfiniteCause::exposure)], 1u);
  EXPECT_EQ(counters.nonfinite_samples, 1u);
}

// The camera looks at a mirror that shines, in a dome of the largest radiance that a light may have.
RenderRequest shining_mirror(float emission, float exposure) {
  testing::SceneBuilder b;
  DisneyParameters mirror;
  mirror.base_color = Rgb(1);
  mirror.metallic = 1;
  mirror.roughness = 0;
  mirror.emission = Rgb(emission);
  b.add(b.prototype(testing::plane_mesh(4)), b.material(mirror));
  b.add(testing::constant_dome(1e35f, true));
  RenderRequest request;
  request.scene = b.snapshot();
  request.camera = testing::look_at({0, 2, 1}, {0, 0, 0}, 10);
  request.camera.exposure = exposure;
  request.width = request.height = 8;
  request.data_window = {0, 0, 8, 8};
  return request;
}

RenderCounters traced_at_the_centre(const RenderRequest& request) {
  RenderCounters counters;
  LightLayers layers;
  const TileRenderer renderer(request);
  for (uint32_t s = 0; s < 16; ++s) renderer.trace_sample({4, 4, s}, &counters, &layers);
  return counters;
}

TEST(TileRenderer, ExposureIsTheCauseOnlyOfWhatWasFiniteBeforeIt) {
  const auto of = [](const RenderCounters& counters, NonfiniteCause cause) {
    return counters.nonfinite_causes[size_t(cause)];
  };
  EXPECT_EQ(traced_at_the_centre(shining_mirror(1e35f, 0)).nonfinite_samples, 0u);
  EXPECT_EQ(of(traced_at_the_centre(shining_mirror(1e35f, 64)), NonfiniteCause::exposure), 16u);
  // Both lights are finite numbers, and their sum is none.
  for (const float exposure : {0.0f, 1.0f, 64.0f}) {
    const RenderCounters sums = traced_at_the_centre(shining_mirror(std::numeric_limits<float>::max(), exposure));
    EXPECT_EQ(of(sums, NonfiniteCause::other), 16u) << exposure;
    EXPECT_EQ(sums.nonfinite_samples, 16u) << exposure;
  }
}

// In a ball that loses no light some walks are long.
TEST(TileRenderer, ACancelledSampleIsLeftAndLeavesNoTrace) {
  testing::SceneBuilder b;
  DisneyParameters white;
  white.base_color = Rgb(1.0f);
  white.scatter_distance = Rgb(2e-4f);
  RenderRequest request = mixed_request(2);
  request.settings.walk_guiding = request.settings.walk_sphere_steps = false;
  b.add(b.prototype(testing::sphere_mesh(0.5f, 16, true)), b.material(white),
        Matrix4d().setTranslation(Vec3d(0, 0.5, 0)));
  b.add(testing::constant_dome(0.3f, true));
  request.scene = b.snapshot();
  FilmTile tile(kPixels, request.aovs), whole(kPixels, request.aovs);
  RenderCounters counters;
  const std::atomic<bool> stop{true};
  ASSERT_FALSE(TileRenderer(request, CancelToken(&stop)).render(samples_of({2}), always, &tile, &counters));
  EXPECT_EQ(counters.walk_safety_cap, 0u);
  // The next call takes the samples that are missing.
  ASSERT_TRUE(TileRenderer(request).render(samples_of({2}), always, &tile, &counters));
  ASSERT_TRUE(TileRenderer(request).render(samples_of({2}), always, &whole, &counters));
  EXPECT_TRUE(same_bytes(contents(tile), contents(whole)));
}

}  // namespace
}  // namespace alabaster
