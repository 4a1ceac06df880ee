#include "delegate/tradeoff/prediction.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <utility>

namespace alabaster::tradeoff {
namespace {

/// A scene whose error follows the model of prediction.h exactly.
struct ModelScene {
  double level = 1, outlines = 20, exponent = 1.03, cost = 1e-6;
  double law = 0.05;  // uncertainty of ln E^2 that all estimates share
  double shift = 0;   // the error that they share

  double error(double pixels, double samples) const {
    return std::sqrt((level + outlines / std::sqrt(pixels)) * std::pow(samples, -exponent));
  }
  double samples_for(double pixels, double target) const {
    return kOvershoot * std::pow((level + outlines / std::sqrt(pixels)) / (target * target), 1 / exponent);
  }
  /// The report of a render whose estimate of ln E^2 is off by `deviation` standard deviations `sigma`.
  Probe probe(double pixels, double samples, double sigma, double deviation = 0) const {
    Probe p{pixels, samples, cost * pixels * samples / 2, cost * pixels * samples, 0, 0, 0};
    p.error = error(pixels, samples) * std::exp((deviation * sigma + shift) / 2);
    const double reach = 1.96 * std::sqrt(2 * sigma * sigma + law * law);  // a frame's own error has the same scatter
    p.low = p.error * std::exp(-reach / 2);
    p.high = p.error * std::exp(reach / 2);
    return p;
  }
};

TEST(Prediction, FollowsSizeSamplesAndCost) {
  const ModelScene scene;
  const std::vector<Probe> probes{scene.probe(2500, 64, 0.001), scene.probe(10000, 64, 0.001),
                                  scene.probe(10000, 256, 0.001)};
  for (const double target : {0.2, 0.05, 0.02}) {
    const double pixels = 921600, expected = scene.samples_for(pixels, target);
    const Prediction p = predict(probes, pixels, target, 1);
    ASSERT_TRUE(p.known);
    EXPECT_NEAR(p.samples.value / expected, 1, 0.06) << target;
    EXPECT_LT(p.samples.low, expected);
    EXPECT_GT(p.samples.high, expected);
    EXPECT_NEAR(p.cpu.value / (p.samples.value * pixels * scene.cost), 1, 1e-9);
    EXPECT_NEAR(p.wall.value / p.cpu.value, 0.5, 1e-9);
  }
}

// With many outlines, a pixel of the frame needs fewer samples than a pixel of the coarser probe. Without outlines the
// size does not matter.
TEST(Prediction, OutlinesAreSeparatedFromPixelNoise) {
  for (const double outlines : {0.0, 60.0}) {
    const ModelScene scene{1, outlines, 1};
    const std::vector<Probe> probes{scene.probe(2500, 16, 0.01), scene.probe(10000, 16, 0.01),
                                    scene.probe(10000, 64, 0.01)};
    const Prediction p = predict(probes, 1e6, 0.05, 1);
    EXPECT_NEAR(p.samples.value / scene.samples_for(1e6, 0.05), 1, 0.15) << outlines;
  }
}

/// Counts the scenes of 1000 that lie within the range, and finds its largest width, high over low. `law` is the error
/// that all estimates of a scene share.
std::pair<int, double> ranges_that_hold(double law) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  int inside = 0;
  double widest = 1;
  for (int i = 0; i < 1000; ++i) {
    const ModelScene scene{1, 10 + 4 * normal(random), 1 + 0.04 * normal(random), 1e-6, law, law * normal(random)};
    const std::vector<Probe> probes{scene.probe(2500, 16, 0.2, normal(random)),
                                    scene.probe(10000, 16, 0.1, normal(random)),
                                    scene.probe(10000, 64, 0.1, normal(random))};
    const Prediction p = predict(probes, 1e6, 0.04, 1);
    const double truth = scene.samples_for(1e6, 0.04);
    inside += p.samples.low < truth && truth < p.samples.high ? 1 : 0;
    widest = std::max(widest, p.samples.high / p.samples.low);
  }
  return {inside, widest};
}

TEST(Prediction, TheRangeHoldsWhatItPromises) {
  const auto [inside, widest] = ranges_that_hold(0.05);
  EXPECT_GE(inside, 950);
  EXPECT_LT(widest, 5) << "or the range is useless";
}

// Where stratification dominates, all probes of a scene share an error, and more probes do not narrow the range.
TEST(Prediction, ErrorsCommonToAllProbesAreKept) {
  const auto [inside, widest] = ranges_that_hold(0.5);
  EXPECT_GE(inside, 950);
  EXPECT_LT(widest, 20);
}

// Quarters of the pixels end a render. Their errors are above the frame's where that is small.
TEST(Prediction, TheErrorOfGroupsEndsARender) {
  const ModelScene scene;
  std::vector<Probe> probes{scene.probe(10000, 64, 0.001), scene.probe(10000, 256, 0.001)};
  const double alone = predict(probes, 10000, 0.05, 1).samples.value;
  for (Probe& p : probes) p.groups = 1.2;
  const double in_groups = predict(probes, 10000, 0.05, 1).samples.value;
  EXPECT_NEAR(in_groups / alone, 1.2 * 1.2, 0.1);
  for (Probe& p : probes) p.groups = 20;
  EXPECT_LT(predict(probes, 10000, 0.05, 1).samples.value, 3 * alone) << "a few bright samples";
}

TEST(Prediction, SamplesAreNeverFewerThanTheFirstErrorCheck) {
  const ModelScene scene;
  const Prediction p = predict({scene.probe(1000, 16, 0.05)}, 1000, 0.9, 16);
  ASSERT_TRUE(p.known);
  EXPECT_EQ(p.samples.value, 16);
  EXPECT_GE(p.samples.low, 16);
  EXPECT_NEAR(p.cpu.value, 16 * 1000 * scene.cost, 1e-9);
}

TEST(Prediction, WithoutNoiseTheFirstLookIsEnough) {
  EXPECT_FALSE(predict({}, 1000, 0.1, 16).known);
  const Prediction p = predict({{1000, 32, 0.1, 0.2, 0, 0, 0}}, 2000, 0.1, 16);
  ASSERT_TRUE(p.known);
  EXPECT_EQ(p.samples.value, 16);
  EXPECT_NEAR(p.cpu.value, 0.2, 1e-9);
}

// A probe whose interval reaches down to zero still counts, and one of few samples does no harm.
TEST(Prediction, AnUncertainProbeCountsLittle) {
  const ModelScene scene{1, 0, 1};
  Probe wild{2500, 16, 0.1, 0.1, 5, 0, 10};
  const Prediction p = predict({wild, scene.probe(10000, 64, 0.02)}, 10000, 0.05, 1);
  EXPECT_NEAR(p.samples.value / scene.samples_for(10000, 0.05), 1, 0.2);
}

}  // namespace
}  // namespace alabaster::tradeoff
