// Calibration against references: testenv/statistical/frame_error_test.cpp.
#include "core/convergence/frame_error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <tuple>

#include <tbb/task_arena.h>

#include "core/sampling/pixel_sampler.h"

namespace alabaster {
namespace {

// Noise of the law V = a / m + b / m^2 that all pixels have to the letter, at 16 samples.
NoiseImage image_of_law(double a, double b, float level) {
  const auto variance = [&](double m) { return a / m + b / (m * m); };
  const auto difference = [&](double m) { return static_cast<float>(2 * std::sqrt(variance(m / 2) - variance(m))); };
  NoiseImage image{5, 4, {}};
  image.pixels.assign(
      20,
      {.samples = 16, .level = level, .latest = difference(16), .previous = difference(8), .earlier = difference(4)});
  return image;
}

TEST(FrameError, EstimateFollowsTheModelOfNoise) {
  const double scale = 4 * (1 + kErrorFloor * kErrorFloor);  // L = 2
  for (const auto& [a, b] : {std::pair{1.0, 0.0}, std::pair{1.0, 1.0}, std::pair{0.5, 20.0}, std::pair{3.0, 7.0}}) {
    const FrameError error = estimate_frame_error(image_of_law(a, b, 2));
    EXPECT_TRUE(error.known);
    EXPECT_NEAR(error.relative_rmse, std::sqrt((a / 16 + b / 256) / scale), 1e-6) << a << " " << b;
    EXPECT_LT(error.low, error.relative_rmse);
    EXPECT_GT(error.high, error.relative_rmse);
  }
}

// A law without noise, V = b / m^3: faster than the sum can fall.
TEST(FrameError, FollowsASmoothIntegrand) {
  NoiseImage image{5, 4, {}};
  image.pixels.assign(20, {.samples = 16,
                           .level = 1,
                           .latest = std::sqrt(7.0f),
                           .previous = std::sqrt(56.0f),
                           .earlier = std::sqrt(448.0f)});
  const double variance = 7.0 / 4 / 7;  // V(8) - V(16) = 7 V(16)
  EXPECT_NEAR(estimate_frame_error(image).relative_rmse, std::sqrt(variance / (1 + kErrorFloor * kErrorFloor)), 1e-6);
}

// A pattern of two pixels whose outlines are resolved by the eighth sample: m V(m) is 0.61, 0.43, 0.082, 0.080 at 2 to
// 16 samples, and 0.073 at 32. At both ends the differences still show the step, which is over.
TEST(FrameError, NoiseThatAStepLeavesLiesInTheInterval) {
  constexpr double kVariance[] = {0.304, 0.1085, 0.01025, 0.0050, 0.0023};  // at 2, 4, 8, 16 and 32 samples
  for (const int last : {3, 4}) {
    const auto difference = [&](int back) {
      return static_cast<float>(2 * std::sqrt(kVariance[last - back - 1] - kVariance[last - back]));
    };
    NoiseImage image{40, 30, {}};
    image.pixels.assign(1200, {.samples = 2u << last,
                               .level = 1,
                               .latest = difference(0),
                               .previous = difference(1),
                               .earlier = difference(2)});
    const FrameError error = estimate_frame_error(image);
    const double truth = std::sqrt(kVariance[last] / (1 + kErrorFloor * kErrorFloor));
    EXPECT_LT(error.low, truth) << last;
    EXPECT_GT(error.high, truth) << last;
    EXPECT_LT(error.high, 1.5 * truth) << last;
  }
}

TEST(FrameError, DoesNotDependOnTheUnitOfLight) {
  const NoiseImage image = image_of_law(1, 2, 1);
  for (const float unit : {0x1p-100f, 0x1p2f, 0x1p100f}) {  // 8e-31 to 1e30
    NoiseImage other = image;
    for (PixelNoise& p : other.pixels) {
      for (float* x : {&p.level, &p.latest, &p.previous, &p.earlier}) *x *= unit;
    }
    EXPECT_EQ(estimate_frame_error(other).relative_rmse, estimate_frame_error(image).relative_rmse) << unit;
    EXPECT_TRUE(estimate_frame_error(other).known);
  }
}

TEST(FrameError, IsUnknownAndNoSmallOneWhereAPixelIsNotFinite) {
  for (const float fault : {std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN()}) {
    NoiseImage image = image_of_law(1, 0, 1);
    image.pixels[3].latest = fault;
    const FrameError error = estimate_frame_error(image);
    EXPECT_FALSE(error.known);
    EXPECT_FALSE(error.relative_rmse <= 1e30) << "no target ends the frame";
  }
}

TEST(FrameError, IsUnknownUntilEveryPixelHasTwoSamples) {
  NoiseImage image = image_of_law(1, 0, 1);
  image.pixels.back().samples = 1;
  EXPECT_FALSE(estimate_frame_error(image).known);
  EXPECT_TRUE(relative_squared_errors(image).empty());
  EXPECT_FALSE(estimate_frame_error(NoiseImage{}).known);
}

// A dark frame of 24 x 24 pixels in which every `step`th pixel of a row has met light, `brightness` times the rest.
NoiseImage dark_with_hits(int step, float brightness) {
  NoiseImage image{24, 24, {}};
  image.pixels.assign(24 * 24, {.samples = 16, .level = 1, .latest = 0.5f, .previous = 0.7f, .earlier = 1});
  for (size_t i = 5; i < image.pixels.size(); i += size_t(step)) {
    image.pixels[i].level = 1 + brightness;
    image.pixels[i].latest = 0.5f + 2 * brightness;
  }
  return image;
}

// One pixel cannot tell a stray path from a caustic that its neighbours have missed. Many can.
TEST(FrameError, ErrorThatRestsOnOnePixelIsUnbounded) {
  const FrameError one = estimate_frame_error(dark_with_hits(1000, 500));
  EXPECT_TRUE(one.known);
  EXPECT_FALSE(one.is_bounded());
  EXPECT_LT(one.low, std::sqrt(81.0 / 576)) << "a caustic's: its level is a ninth of the pixel's at least";
  EXPECT_GT(one.high, 400 / 24.0) << "a stray path's";
  const FrameError many = estimate_frame_error(dark_with_hits(7, 500));
  EXPECT_TRUE(many.is_bounded());
  EXPECT_LT(many.high / many.low, 10);
}

TEST(FrameError, ChangesWithoutAJump) {
  FrameError before = estimate_frame_error(dark_with_hits(31, 0.001f));
  const auto step = [](double now, double then) { return std::abs(std::log(now / then)); };
  for (float brightness = 0.001f; brightness < 1e4f; brightness *= 1.02f) {
    const FrameError now = estimate_frame_error(dark_with_hits(31, brightness));
    EXPECT_LT(step(now.relative_rmse, before.relative_rmse), 0.05) << brightness;
    EXPECT_LT(step(now.low, before.low), 0.06) << brightness;
    EXPECT_LT(step(now.high, before.high), 0.06) << brightness;
    before = now;
  }
}

// Levels are computed in blocks of pixels, which must not show: light that few samples find counts across their edges.
TEST(FrameError, DoesNotDependOnWhereRareLightLies) {
  const auto error_with_hits_at = [](int x0, int y0) {
    NoiseImage image{400, 300, {}};
    image.pixels.assign(400 * 300, {.samples = 16, .level = 1, .latest = 0.5f, .previous = 0.7f, .earlier = 1});
    for (const auto& [x, y, light] : {std::tuple{0, 0, 90.0f}, {3, 1, 60.0f}, {-2, 4, 70.0f}, {1, -5, 40.0f}}) {
      PixelNoise& pixel = image.pixels[size_t(y0 + y) * 400 + size_t(x0 + x)];
      pixel.level = light, pixel.latest = 2 * light;
    }
    return estimate_frame_error(image);
  };
  const FrameError within = error_with_hits_at(60, 60);
  for (const auto& [x, y] : {std::pair{127, 60}, {129, 127}, {255, 128}, {60, 130}}) {
    const FrameError across = error_with_hits_at(x, y);
    EXPECT_NEAR(across.relative_rmse / within.relative_rmse, 1, 1e-9) << x << " " << y;
    EXPECT_NEAR(across.high / within.high, 1, 1e-9) << x << " " << y;
  }
}

// Few bright samples may lie in a pixel's first ones by chance, which then looks like a law.
TEST(FrameError, FewBrightSamplesKeepTheIntervalWide) {
  NoiseImage image = dark_with_hits(1000, 500);
  const double expected = estimate_frame_error(image).high;
  image.pixels[5].previous = 2 * image.pixels[5].latest;  // its hit is one of the first two samples
  image.pixels[5].earlier = 4 * image.pixels[5].latest;
  EXPECT_GT(estimate_frame_error(image).high, 0.7 * expected);
}

TEST(FrameError, UnseenLightIsNotZeroError) {
  NoiseImage image{4, 4, {}};
  image.pixels.assign(16, {.samples = 16, .level = 1});
  EXPECT_FALSE(estimate_frame_error(image).is_bounded()) << "light that no sample has met is not known";
  image.pixels[2].level = std::numeric_limits<float>::infinity();
  EXPECT_FALSE(estimate_frame_error(image).known);
  EXPECT_FALSE(estimate_frame_error(image).relative_rmse <= 1e30);
}

TEST(FrameError, BlackFrameHasZeroError) {
  NoiseImage image{2, 1, {}};
  image.pixels.assign(2, {.samples = 4});
  const FrameError error = estimate_frame_error(image);
  EXPECT_TRUE(error.known);
  EXPECT_EQ(error.relative_rmse, 0);
  EXPECT_EQ(error.high, 0);
  EXPECT_FALSE(error.is_bounded()) << "no sample may have found its light";
}

// A pixel that is much brighter than all around it does not count its own level.
TEST(FrameError, FireflyDoesNotRaiseItsOwnReferenceLevel) {
  NoiseImage image = image_of_law(1, 0, 1);
  image.pixels[7].latest = 1e3f;
  const auto with_level = [&](float level) {
    image.pixels[7].level = level;
    return relative_squared_errors(image)[7] / relative_squared_errors(image)[0];
  };
  EXPECT_NEAR(with_level(1000) / with_level(1), 1, 0.05);
}

TEST(FrameError, SamplesForAnErrorFallWithItsSquare) {
  EXPECT_EQ(samples_for_error(1000, 4096, 0.011, 0.01), 1210u);
  EXPECT_EQ(samples_for_error(1000, 1100, 0.02, 0.01), 1100u) << "never more than allowed";
}

// Sums of floating-point numbers depend on their order, which no thread may decide.
TEST(FrameError, NoBitDependsOnThreads) {
  NoiseImage image{301, 173, {}};  // several blocks of pixels, the last one not full
  for (uint32_t i = 0; i < 301 * 173; ++i) {
    const auto number = [&](uint32_t which) { return to_unit_float(hash32(5 * i + which)); };
    image.pixels.push_back({.samples = 24 + i % 3,
                            .level = number(0),
                            .latest = number(1),
                            .previous = 2 * number(2),
                            .earlier = 4 * number(3),
                            .tail = number(4)});
  }
  FrameError one;
  std::vector<double> errors_of_one;
  tbb::task_arena(1).execute([&] {
    one = estimate_frame_error(image);
    errors_of_one = relative_squared_errors(image);
  });
  for (int repeat = 0; repeat < 20; ++repeat)
    tbb::task_arena(2).execute([&] {
      const FrameError many = estimate_frame_error(image);
      EXPECT_EQ(many.relative_rmse, one.relative_rmse);
      EXPECT_EQ(many.low, one.low);
      EXPECT_EQ(many.high, one.high);
      EXPECT_EQ(relative_squared_errors(image), errors_of_one);
    });
}

}  // namespace
}  // namespace alabaster
