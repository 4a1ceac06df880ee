// Tests a frame's estimate of its own noise: many small renders against a reference with 64 times their samples.
#include "core/convergence/frame_error.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/sampling/pixel_sampler.h"
#include "testenv/support/relative_error.h"
#include "testenv/support/scene_builder.h"
#include "testenv/support/z_test.h"

namespace alabaster {
namespace {

using testing::relative_mse;
using testing::SceneBuilder;

constexpr uint32_t kSamples = 32;
constexpr int kSize = 24;

RenderRequest request_of(SceneBuilder& builder) {
  RenderRequest request;
  request.scene = builder.snapshot();
  request.camera = testing::look_at({0, 1.2, 3}, {0, 0.5, 0}, 35);
  request.width = request.height = kSize;
  request.data_window = {0, 0, kSize, kSize};
  request.settings.samples = kSamples;
  return request;
}

LightParameters ball_light(float radius, float intensity) {
  LightParameters key;
  key.type = LightType::sphere;
  key.radius = radius;
  key.intensity = intensity;
  key.light_to_world.setTranslation(Vec3d(2, 3, 1));
  return key;
}

void add_ball_on_floor(SceneBuilder* b, const DisneyParameters& ball) {
  b->add(b->prototype(testing::sphere_mesh(0.5f, 16, true)), b->material(ball),
         Matrix4d().setTranslation(Vec3d(0, 0.5, 0)));
  b->add(b->prototype(testing::plane_mesh(4)), b->material({}));
}

RenderRequest skin_under_dome() {
  SceneBuilder b;
  DisneyParameters skin;
  skin.base_color = {0.9f, 0.6f, 0.45f};
  skin.scatter_distance = {0.1f, 0.05f, 0.03f};
  add_ball_on_floor(&b, skin);
  b.add(testing::constant_dome(0.3f, true)).add(ball_light(0.3f, 20));
  return request_of(b);
}

RenderRequest marble_in_hard_light() {
  SceneBuilder b;
  DisneyParameters marble;
  marble.base_color = {0.95f, 0.93f, 0.88f};
  marble.scatter_distance = {0.2f, 0.15f, 0.1f};
  add_ball_on_floor(&b, marble);
  b.add(ball_light(0.02f, 2000));
  return request_of(b);
}

RenderRequest gloss_without_subsurface() {
  SceneBuilder b;
  DisneyParameters gloss;
  gloss.metallic = 1;
  gloss.roughness = 0.3f;
  add_ball_on_floor(&b, gloss);
  b.add(ball_light(0.3f, 20)).add(testing::constant_dome(0.1f, true));
  return request_of(b);
}

struct Calibration {
  int inside = 0, frames = 0;
  testing::RunningStatistics ratio;  // estimated over true squared error
};

std::shared_ptr<const Film> converged(RenderRequest request) {
  request.settings.samples = 64 * kSamples;
  request.settings.seed = 1000;
  return testing::render(request);
}

// Rendered once for both tests.
const Film& converged_skin() {
  static const std::shared_ptr<const Film> film = converged(skin_under_dome());
  return *film;
}

Calibration calibrate(RenderRequest request, const Film& film, int frames) {
  const std::vector<float> reference = film.resolve_float(Aov::color);
  const double left = std::pow(estimate_frame_error(film).relative_rmse, 2);  // noise of the reference

  Calibration result;
  for (int i = 0; i < frames; ++i) {
    request.settings.seed = uint32_t(i);
    const auto frame = testing::render(request);
    const FrameError error = estimate_frame_error(*frame);
    EXPECT_TRUE(error.known);
    const double truth = relative_mse(frame->resolve_float(Aov::color), reference, kSize, kSize) - left;
    result.inside += truth >= error.low * error.low && truth <= error.high * error.high ? 1 : 0;
    result.ratio.add(error.relative_rmse * error.relative_rmse / truth);
  }
  result.frames = frames;
  return result;
}

TEST(FrameErrorInterval, TheTrueErrorLiesInTheIntervalThatFramesReport) {
  int inside = 0, frames = 0;
  const RenderRequest marble = marble_in_hard_light(), gloss = gloss_without_subsurface();
  for (const Calibration& c : {calibrate(skin_under_dome(), converged_skin(), 20),
                               calibrate(marble, *converged(marble), 20), calibrate(gloss, *converged(gloss), 20)}) {
    std::printf("inside %d of %d; estimated / true squared error %.3f +- %.3f\n", c.inside, c.frames, c.ratio.mean(),
                c.ratio.standard_error());
    inside += c.inside;
    frames += c.frames;
    EXPECT_TRUE(plausible(z_test(c.ratio, 1)));
    EXPECT_LT(c.ratio.standard_error(), 0.1) << "or the comparison proves nothing";
  }
  EXPECT_GE(inside, 50) << "of " << frames << ": four sigma below 57 +- 1.7, 95 %";
}

constexpr int kPixels = 96;  // width and height of the films below

// value(x, y, s): of sample s of pixel (x, y), in grey.
template <class Value>
void add_samples(Film* film, uint32_t samples, const Value& value) {
  for (int t = 0; t < film->tile_count(); ++t) {
    const PixelRect r = film->tile_rect(t);
    FilmTile tile = film->load_tile(t);
    size_t pixel = 0;
    for (int y = r.y0; y < r.y1; ++y)
      for (int x = r.x0; x < r.x1; ++x, ++pixel)
        for (uint32_t s = 0; s < samples; ++s) {
          FilmSample sample;
          sample.color = Rgb(value(x, y, s));
          tile.add(pixel, sample);
        }
    film->store_tile(t, tile);
  }
}

// Integrands with known variance, by the renderer's sampler: a mean of u - 1/2 has variance 1 / (12 n^3) where n = 2^m
// strata have one sample each, and a coin tossed by a stream of its own has sigma^2 / n. The estimate must follow both
// and mixtures of them, at powers of two and in between.
double ratio_of_estimate(double coin, uint32_t samples) {
  double estimated = 0, truth = 0;
  for (uint32_t seed = 0; seed < 4; ++seed) {
    Film film({0, 0, kPixels, kPixels}, 0);
    add_samples(&film, samples, [&](int x, int y, uint32_t s) {
      const PixelSampler sampler(pixel_seed(x, y, 0, seed), s);
      const float toss = sampler.stream(Dimension::subsurface, 0).uniform() < 0.5f ? -1 : 1;
      return 0.5f + sampler.draw(Dimension::bsdf, 0)[0] + float(coin) * toss;
    });
    const FrameError error = estimate_frame_error(film);
    estimated += std::pow(error.relative_rmse, 2) / 4;
    truth +=
        relative_mse(film.resolve_float(Aov::color), std::vector<float>(4 * kPixels * kPixels, 1), kPixels, kPixels) /
        4;
  }
  return estimated / truth;
}

TEST(FrameErrorInterval, FollowsTheConvergence) {
  for (const uint32_t samples : {8u, 32u, 48u, 56u, 64u}) {
    EXPECT_NEAR(ratio_of_estimate(0, samples), 1, 0.1) << samples;
    EXPECT_NEAR(ratio_of_estimate(1, samples), 1, 0.1) << samples;
    // A smooth integrand of one dimension with noise falls as a / n + b / n^3, which the law a / n + b / n^2 follows
    // within about a fifth. Eight samples cannot show that such a steep fall is about to end in noise: their estimate
    // is half of it.
    if (samples > 8) {
      EXPECT_NEAR(ratio_of_estimate(0.1, samples), 1, 0.25) << samples;
    }
  }
}

// A hair across a pixel: the strip |n . (p - 1/2) - offset| < half_width of the unit square, with a normal n of its
// own.
struct Hair {
  float nx, ny, offset, half_width;
  float operator()(float x, float y) const {
    return std::abs(nx * (x - 0.5f) + ny * (y - 0.5f) - offset) < half_width ? 1.0f : 0.2f;
  }
  static Hair of(int x, int y) {
    const auto u = PixelSampler(pixel_seed(x, y, 7, 0), 0).draw(Dimension::time, 0);
    const float angle = 6.2831853f * u[0];
    return {std::cos(angle), std::sin(angle), 0.5f * (u[1] - 0.5f), 0.03f + 0.12f * u[2]};
  }
  float mean() const {  // exact to a step of a row of 1 / 512 of a pixel
    constexpr int kSteps = 512;
    double sum = 0;
    for (int j = 0; j < kSteps; ++j)
      for (int i = 0; i < kSteps; ++i) sum += double((*this)((float(i) + 0.5f) / kSteps, (float(j) + 0.5f) / kSteps));
    return float(sum / (kSteps * kSteps));
  }
};

// The variance of thin strips falls as n^-1.25 at every number of samples: finer strata resolve narrower parts. The law
// reads the same differences as noise beside a part that is nearly resolved, so E is reported too large.
TEST(FrameErrorInterval, ErrorOfThinGeometryLiesInTheInterval) {
  std::vector<float> reference(4 * kPixels * kPixels, 1);
  for (int i = 0; i < kPixels * kPixels; ++i)
    std::fill_n(&reference[size_t(4 * i)], 3, Hair::of(i % kPixels, i / kPixels).mean());
  for (const uint32_t samples : {16u, 64u, 256u}) {
    Film film({0, 0, kPixels, kPixels}, 0);
    add_samples(&film, samples, [](int x, int y, uint32_t s) {
      const auto u = PixelSampler(pixel_seed(x, y, 0, 1), s).draw(Dimension::film_lens, 0);
      return Hair::of(x, y)(u[0], u[1]);
    });
    const FrameError error = estimate_frame_error(film);
    const double truth = std::sqrt(relative_mse(film.resolve_float(Aov::color), reference, kPixels, kPixels));
    std::printf("%u samples: error %.4f, reported %.4f (%.4f to %.4f)\n", samples, truth, error.relative_rmse,
                error.low, error.high);
    EXPECT_GE(truth, error.low) << samples;
    EXPECT_LE(truth, error.high) << samples;
    EXPECT_LT(error.high, 2 * error.low) << samples;
  }
}

TEST(FrameErrorInterval, ABlackFrameEndsAtOnce) {
  SceneBuilder b;
  add_ball_on_floor(&b, {});
  RenderRequest request = request_of(b);
  request.settings.samples = 65536;
  request.settings.target_error = 0.05f;
  RenderProgress progress;
  testing::render(request, &progress);
  EXPECT_TRUE(progress.noise.known);
  EXPECT_EQ(progress.samples_done, 16u * kSize * kSize);
}

TEST(FrameErrorInterval, EndsTheRenderAtTheErrorAsked) {
  RenderRequest request = skin_under_dome();
  const auto reference = converged_skin().resolve_float(Aov::color);
  int good = 0;
  double estimates = 0;
  for (uint32_t seed = 0; seed < 10; ++seed) {
    request.settings.seed = seed;
    request.settings.samples = 65536;
    request.settings.target_error = 0.05f;
    RenderProgress progress;
    const auto film = testing::render(request, &progress);
    EXPECT_EQ(progress.state, SessionState::finished);
    // Few rare bright paths make an estimate above the target; its interval is then wide.
    EXPECT_LE(progress.noise.low, 0.05);
    estimates += progress.noise.relative_rmse;
    EXPECT_LT(progress.samples_done, uint64_t(2000) * kSize * kSize);
    const double truth = std::sqrt(relative_mse(film->resolve_float(Aov::color), reference, kSize, kSize));
    good += truth > 0.04 && truth < 0.06 ? 1 : 0;
  }
  EXPECT_GE(good, 9);
  EXPECT_LE(estimates / 10, 0.055);
}

}  // namespace
}  // namespace alabaster
