// Light of light paths belongs to samples of pixels: threads, tiles, crops and layers change no byte of it.
#include "core/session/light_landings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <thread>
#include <utility>

#include "core/session/tile_renderer.h"
#include "testenv/support/ball_on_floor.h"
#include "testenv/support/path_tracer.h"
#include "testenv/support/same_bytes.h"

namespace alabaster {
namespace {

using testing::same_bytes;

// A metal ball on a matt floor, in the light of a small sphere.
RenderRequest caustic_request(uint32_t samples) {
  testing::SceneBuilder b;
  testing::add_ball_on_floor(testing::metal(0.15f), testing::matt(Rgb(0.5f)), testing::small_light(), &b);
  RenderRequest request;
  request.scene = b.snapshot();
  request.camera = testing::look_at({0.3, 4, 4}, {0, 0, 0}, 40);
  request.width = request.height = 72;
  request.data_window = {0, 0, 72, 72};
  request.settings.samples = samples;
  request.settings.threads = 1;
  return request;
}

std::vector<float> color_of(const RenderRequest& request) {
  return testing::render(request)->resolve_float(Aov::color);
}

// The landings of a request, for tests that ask for them alone.
struct Landings {
  RenderRequest request;
  Camera camera{request.camera, request.width, request.height, request.scene->origin};
  IntegratorSettings settings = integrator_settings(request.settings);
  LightLandings of{{*request.scene, camera, settings, request.width, request.height, request.data_window,
                    request.settings.filter, request.settings.frame, request.settings.seed}};
};

double sum_of(const LandedSample& sample, const PixelRect& window) {
  double sum = 0;
  for (int y = window.y0; y < window.y1; ++y)
    for (int x = window.x0; x < window.x1; ++x)
      if (const LandedLight* light = sample.find(x, y)) sum += double(light->color.g);
  return sum;
}

TEST(LightLandings, AllSamplesButTheFirstHaveThem) {
  Landings landings{caustic_request(4)};
  EXPECT_EQ(landings.of.plan(0), nullptr);
  ASSERT_NE(landings.of.plan(1), nullptr);
  RenderCounters counters;
  const auto one = landings.of.of_sample(1, &counters), two = landings.of.of_sample(2, &counters);
  EXPECT_GT(sum_of(*one, landings.request.data_window), 0);
  EXPECT_NE(sum_of(*one, landings.request.data_window), sum_of(*two, landings.request.data_window));
  EXPECT_EQ(landings.of.of_sample(1, &counters), one) << "traced once";
  EXPECT_EQ(one->find(5, -1), nullptr);
  EXPECT_EQ(one->find(5, 72), nullptr);
}

// Filters blur what lands, and keep its sum but for the borders.
TEST(LightLandings, EveryFilterGivesAsMuch) {
  const auto mean_of = [](PixelFilter filter) {
    RenderRequest request = caustic_request(4);
    request.settings.filter = filter;
    Landings landings{std::move(request)};
    EXPECT_NE(landings.of.plan(1), nullptr);
    RenderCounters counters;
    double sum = 0;
    for (uint32_t s = 1; s <= 40; ++s) sum += sum_of(*landings.of.of_sample(s, &counters), {8, 8, 64, 64});
    return sum / 40;
  };
  const double box = mean_of(PixelFilter::box);
  EXPECT_GT(box, 0);
  for (const PixelFilter filter : {PixelFilter::triangle, PixelFilter::gaussian, PixelFilter::blackman_harris})
    EXPECT_NEAR(mean_of(filter), box, 0.03 * box);
}

TEST(LightLandings, ThreadsTileAndPassesChangeNoByte) {
  RenderRequest request = caustic_request(6);
  const auto one = color_of(request);
  request.settings.threads = 5;
  EXPECT_TRUE(same_bytes(one, color_of(request)));
}

// A pixel that asks for light paths first, which depends on threads, costs no more than if another has asked before.
TEST(LightLandings, RaysOfLightPathsAreNoCostOfPixels) {
  const RenderRequest request = caustic_request(16);
  const TileRenderer renderer(request);
  const auto costs = [&] {
    const PixelRect rect{20, 20, 24, 24};
    FilmTile tile(16, 0, {.rays = true, .range = {}});
    RenderCounters counters;
    EXPECT_TRUE(renderer.render(
        {rect, {16}, SampleAllocation()}, [] { return true; }, &tile, &counters));
    std::vector<uint32_t> rays;
    for (size_t pixel = 0; pixel < 16; ++pixel) rays.push_back(tile.rays(pixel));
    return std::pair(rays, counters.rays());
  };
  const auto first = costs(), later = costs();
  EXPECT_EQ(first.first, later.first);
  EXPECT_GT(first.second, later.second) << "or it traced no light paths";
}

TEST(LightLandings, AdaptiveFramesHaveThemAndThreadsChangeNoByte) {
  RenderRequest request = caustic_request(128);
  const auto even = testing::render(request);
  request.settings.adaptive = true;
  ASSERT_TRUE(integrator_settings(request.settings).light_paths);
  const auto one = testing::render(request);
  request.settings.threads = 5;
  EXPECT_TRUE(same_bytes(one->resolve_float(Aov::color), color_of(request)));

  const auto counts = one->resolve_int(Aov::sample_count);
  EXPECT_GT(*std::max_element(counts.begin(), counts.end()), 200) << "or no pixel takes several samples at once";
  EXPECT_LT(*std::min_element(counts.begin(), counts.end()), 80) << "or no pixel leaves out a sample of the frame";

  // The caustic is as bright as in a frame that is sampled evenly.
  Landings landings{caustic_request(128)};
  RenderCounters counters;
  ASSERT_NE(landings.of.plan(1), nullptr);
  const double pixels = 72 * 72, mean = testing::film_mean(*even, 1).mean;
  double caustic = 0;
  for (uint32_t s = 1; s < 128; ++s) caustic += sum_of(*landings.of.of_sample(s, &counters), {0, 0, 72, 72});
  EXPECT_GT(caustic / 127 / pixels, 0.02 * mean) << "or the comparison proves nothing";
  EXPECT_NEAR(testing::film_mean(*one, 1).mean, mean, 0.007 * mean);
}

// A pixel with twice as many samples as the frame needs no more light paths than another.
TEST(LightLandings, LightPathsAreThoseOfTheFramesSample) {
  const RenderRequest request = caustic_request(64);
  const auto light_rays = [&](const SampleAllocation& allocation, uint32_t samples) {
    const TileRenderer renderer(request);
    const PixelRect rect{36, 36, 37, 37};
    FilmTile tile(1, 0, {.rays = true, .range = {}});
    RenderCounters counters;
    EXPECT_TRUE(renderer.render(
        {rect, {samples}, allocation}, [] { return true; }, &tile, &counters));
    return counters.rays() - tile.rays(0);
  };
  const SampleAllocation doubled(std::vector<float>(72 * 72, 2.0f));
  EXPECT_EQ(light_rays(doubled, 32), light_rays({}, 32));
  EXPECT_GT(light_rays({}, 48), light_rays({}, 32)) << "or samples have none";
}

TEST(LightLandings, ACropIsAPartOfTheFrame) {
  RenderRequest request = caustic_request(6);
  const auto full = color_of(request);
  request.data_window = {20, 31, 60, 71};
  EXPECT_TRUE(same_bytes(testing::cut_out(full, 72, request.data_window), color_of(request)));
}

TEST(LightLandings, LayersAddUpToTheSameColour) {
  RenderRequest request = caustic_request(6);
  const auto alone = color_of(request);
  request.aovs = ~0u;
  const auto film = testing::render(request);
  EXPECT_TRUE(same_bytes(alone, film->resolve_float(Aov::color)));
  const auto diffuse = film->resolve_float(Aov::diffuse), specular = film->resolve_float(Aov::specular),
             emission = film->resolve_float(Aov::emission);
  for (size_t pixel = 0; pixel < 72 * 72; ++pixel) {
    const double sum = double(diffuse[3 * pixel]) + double(specular[3 * pixel]) + double(emission[3 * pixel]);
    EXPECT_NEAR(sum, double(alone[4 * pixel]), 1e-5 * std::abs(sum) + 1e-7) << pixel;
  }
}

TEST(LightLandings, SamplesOfARangeAreThoseOfTheFrame) {
  const RenderRequest request = caustic_request(3);
  const TileRenderer renderer(request), another(request);
  RenderCounters counters;
  LightLayers layers;
  const Rgb third = renderer.trace_sample({40, 50, 2}, &counters, &layers).color;
  for (uint32_t s = 0; s < 3; ++s) {
    const Rgb color = another.trace_sample({40, 50, s}, &counters, &layers).color;
    EXPECT_EQ(color == third, s == 2);
  }
}

// No thread waits for light paths after a cancel, nor one that shares their tracing.
TEST(LightLandings, CancelEndsAllWhoWait) {
  std::atomic<bool> stop{false};
  Landings landings{caustic_request(4)};
  landings.settings.walk.cancel = CancelToken(&stop);
  ASSERT_NE(landings.of.plan(1), nullptr);
  stop = true;
  std::atomic<int> cancelled{0};
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i)
    threads.emplace_back([&] {
      RenderCounters counters;
      try {
        landings.of.of_sample(3, &counters);
      } catch (const BuildCancelled&) {
        ++cancelled;
      }
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(cancelled, 4);
}

}  // namespace
}  // namespace alabaster
