// Frames that end at a target error, and pixels with more samples than others, must keep their mean on light that few
// samples find.
#include <gtest/gtest.h>

#include <cmath>

#include "core/convergence/group_stopping.h"
#include "core/convergence/sample_allocation.h"
#include "core/sampling/pixel_sampler.h"
#include "testenv/support/scene_builder.h"
#include "testenv/support/z_test.h"

namespace alabaster {
namespace {

using testing::RunningStatistics;
using testing::SceneBuilder;

// One sample in a hundred finds light 100: the mean is one.
constexpr float kChance = 0.01f;
constexpr int kSize = 12;
const PixelRect kWindow{0, 0, kSize, kSize};

void add_samples(Film* film, const SampleAllocation& allocation, uint32_t base, Rng* rng) {
  FilmTile tile = film->load_tile(0);
  for (size_t pixel = 0; pixel < size_t(kSize) * kSize; ++pixel)
    while (tile.samples(pixel) < allocation.samples(pixel, base)) {
      FilmSample sample;
      sample.color = Rgb(rng->uniform() < kChance ? 1 / kChance : 0.0f);
      tile.add(pixel, sample);
    }
  film->store_tile(0, tile);
}

double mean_of(const Film& film) {
  return testing::film_mean(film, 1).mean;
}

// By GroupStopping, or naively: `own` lets the whole frame's error end the whole frame.
double frame_ended_at(double target, bool own, Rng* rng) {
  Film film(kWindow, 0);
  GroupStopping stopping;
  for (uint32_t samples = 16; samples < 4096; samples = next_error_check(samples)) {
    add_samples(&film, {}, samples, rng);
    const NoiseImage noise = film_noise(film);
    if (own && estimate_frame_error(noise).relative_rmse <= target) break;
    if (own) continue;
    stopping.update(film, noise, target);
    if (stopping.all_ended()) break;
  }
  stopping.show_ended(&film);
  return mean_of(film);
}

RunningStatistics many_frames(double target, bool own) {
  Rng rng(testing::run_seed(7), own ? 1 : 2);
  RunningStatistics means;
  for (int i = 0; i < testing::run_samples(4000); ++i) means.add(frame_ended_at(target, own, &rng));
  return means;
}

// promise: trade_off.bias.adaptive
TEST(UnbiasedStopping, OtherPixelsDecideAndTheMeanStays) {
  const auto result = testing::z_test(many_frames(2.5, false), 1);
  EXPECT_TRUE(plausible(result));
}

// The test above can fail: a frame that ends by its own error is biased, here by more than one per cent, because more
// light by chance means less relative error.
TEST(UnbiasedStopping, AFrameThatEndsItselfIsBiased) {
  const auto result = testing::z_test(many_frames(2.5, true), 1);
  EXPECT_GT(std::abs(result.z), 6) << result.report;
}

// promise: trade_off.bias.adaptive
TEST(UnbiasedStopping, SamplesAreDealtOutByOtherPixels) {
  Rng rng(testing::run_seed(11), 3);
  RunningStatistics means;
  double uneven = 0;
  for (int i = 0; i < testing::run_samples(4000); ++i) {
    Film film(kWindow, 0);
    add_samples(&film, {}, kPilotSamples, &rng);
    const SampleAllocation allocation(film, std::vector<uint32_t>(size_t(kSize) * kSize, 1), 64);
    add_samples(&film, allocation, 64, &rng);
    means.add(mean_of(film));
    const auto samples = film.resolve_int(Aov::sample_count);
    uneven += *std::max_element(samples.begin(), samples.end()) > 80 ? 1 : 0;
  }
  EXPECT_GT(uneven, 2000) << "or no pixel had more samples than another";
  const auto result = testing::z_test(means, 1);
  EXPECT_TRUE(plausible(result));
}

// A floor beside a polished ball that reflects the light of a small lamp onto it. Few diffuse paths find that light.
RenderRequest caustic() {
  SceneBuilder b;
  DisneyParameters polished;
  polished.metallic = 1;
  polished.roughness = 0.15f;
  b.add(b.prototype(testing::sphere_mesh(0.5f, 24, true)), b.material(polished),
        Matrix4d().setTranslation(Vec3d(0, 0.5, 0)));
  b.add(b.prototype(testing::plane_mesh(4)), b.material({}));
  LightParameters lamp;
  lamp.type = LightType::sphere;
  lamp.radius = 0.05f;
  lamp.intensity = 500;
  lamp.light_to_world.setTranslation(Vec3d(2, 1, 0));
  b.add(lamp);
  RenderRequest request;
  request.scene = b.snapshot();
  request.camera = testing::look_at({1, 2.5, 1.5}, {0.7, 0, 0}, 35);
  request.width = request.height = 12;
  request.data_window = {0, 0, 12, 12};
  return request;
}

// Means of frames that are sampled evenly, with many samples.
RunningStatistics true_means(RenderRequest request) {
  RunningStatistics truth;
  request.settings.samples = 2048;
  for (uint32_t seed = 0; seed < 16; ++seed) {
    request.settings.seed = 100000 + seed;
    truth.add(mean_of(*testing::render(request)));
  }
  return truth;
}

TEST(UnbiasedStopping, RendersOfRareBrightPathsKeepTheirMean) {
  RenderRequest request = caustic();
  const RunningStatistics truth = true_means(request);
  RunningStatistics frames;
  request.settings.samples = 256;
  request.settings.adaptive = true;
  request.settings.target_error = 0.3f;
  uint64_t samples = 0;
  for (uint32_t seed = 0; seed < testing::run_samples(250u); ++seed) {
    request.settings.seed = seed;
    RenderProgress progress;
    frames.add(mean_of(*testing::render(request, &progress)));
    samples += progress.samples_done;
  }
  const double mean_samples = double(samples) / double(frames.count()) / 144;
  EXPECT_GT(mean_samples, 18);
  EXPECT_LT(mean_samples, 200) << "or the error ended no frame";
  const double sigma = std::hypot(truth.standard_error(), frames.standard_error());
  EXPECT_LT(sigma, 0.01 * truth.mean()) << "or the comparison proves nothing";
  EXPECT_TRUE(plausible(z_test(frames, truth)));
  std::printf("mean %.5f +- %.5f of frames; truth %.5f +- %.5f\n", frames.mean(), frames.standard_error(), truth.mean(),
              truth.standard_error());
}

}  // namespace
}  // namespace alabaster
