// Estimators on synthetic pictures with known bias and noise.
#include "delegate/tradeoff/measurement.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/convergence/frame_error.h"
#include "testenv/support/z_test.h"

namespace alabaster::tradeoff {
namespace {

using alabaster::testing::RunningStatistics;
using alabaster::testing::z_test;

constexpr int kSide = 24;

/// The truth: a slope from 0.2 to 1.2, different in each channel.
double truth(size_t pixel, size_t channel) {
  return 0.2 + double(pixel) / (kSide * kSide) + 0.1 * double(channel);
}

/// Has noise of standard deviation `noise` x truth / sqrt(samples) and a bias of `bias` x truth.
Image picture(std::mt19937& random, double bias, double noise, double samples) {
  std::normal_distribution<double> normal;
  Image image{kSide, kSide, std::vector<float>(3 * kSide * kSide)};
  for (size_t pixel = 0; pixel < image.pixels(); ++pixel)
    for (size_t c = 0; c < 3; ++c)
      image.rgb[3 * pixel + c] =
          static_cast<float>(truth(pixel, c) * (1 + bias + noise / std::sqrt(samples) * normal(random)));
  return image;
}

Image exact() {
  std::mt19937 random(0);
  return picture(random, 0, 0, 1);
}

/// Mean over pixels of truth^2 / scale: the relMSE of a relative error of one.
double relative_unit(const std::vector<double>& scales) {
  double sum = 0;
  for (size_t pixel = 0; pixel < scales.size(); ++pixel)
    for (size_t c = 0; c < 3; ++c) sum += truth(pixel, c) * truth(pixel, c) / scales[pixel] / 3;
  return sum / double(scales.size());
}

ReplicaGroup group_of(std::mt19937& random, double bias, double noise, uint64_t samples, int replicas) {
  ReplicaGroup group(samples);
  for (int r = 0; r < replicas; ++r) group.add(picture(random, bias, noise, double(samples)));
  return group;
}

struct Trial {
  Estimate bias, level;
  double noise;
};

/// A configuration on the rungs 1, 4, 16 with two replicas each, against 4 replicas of a reference of 32 samples.
Trial trial(uint32_t seed, double bias, double noise, const std::vector<double>& scales) {
  std::mt19937 random(seed);
  std::vector<ReplicaGroup> groups;
  for (const uint64_t samples : {1u, 4u, 16u}) groups.push_back(group_of(random, bias, noise, samples, 2));
  const ReplicaGroup reference = group_of(random, 0, noise, 32, 4);
  const PooledMean x = pool(groups), y = pool({&reference, 1});
  return {squared_bias(x, y, scales), mean_level_bias(x, y), squared_noise(groups[1], scales).value};
}

// Pixels of a denoised picture share their noise with neighbours: here in blocks of 8 x 8.
TEST(Measurement, IntervalsOfCorrelatedPixelsComeFromBlocks) {
  constexpr int kSize = 64, kBlock = 8;
  const PixelBlocks blocks{kSize, kBlock};
  const std::vector<double> scales(kSize * kSize, 1.0);
  PooledMean reference;
  reference.mean.assign(4 * kSize * kSize, 1.0);
  reference.variance.assign(4 * kSize * kSize, 0.0);
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  RunningStatistics noise, bias, level;
  double told_noise = 0, told_bias = 0, told_level = 0;
  constexpr int kTrials = 200;
  for (int t = 0; t < kTrials; ++t) {
    ReplicaGroup group(16);
    for (int replica = 0; replica < 2; ++replica) {
      std::vector<double> shift(kSize / kBlock * kSize / kBlock);
      for (double& s : shift) s = 0.2 * normal(random);
      Image image{kSize, kSize, std::vector<float>(3 * kSize * kSize)};
      for (size_t i = 0; i < image.rgb.size(); ++i)
        image.rgb[i] =
            static_cast<float>(1.1 + shift[i / 3 / kSize / kBlock * (kSize / kBlock) + i / 3 % kSize / kBlock]);
      group.add(image);
    }
    const PooledMean mean = pool({&group, 1});
    const Estimate n = squared_noise(group, scales, blocks), b = squared_bias(mean, reference, scales, blocks);
    const Estimate l = mean_level_bias(mean, reference, blocks);
    noise.add(n.value), bias.add(b.value), level.add(l.value);
    told_noise += n.standard_error * n.standard_error / kTrials;
    told_bias += b.standard_error * b.standard_error / kTrials;
    told_level += l.standard_error * l.standard_error / kTrials;
  }
  EXPECT_NEAR(noise.mean(), 0.04, 0.002);
  EXPECT_NEAR(bias.mean(), 0.01, 0.002);
  EXPECT_NEAR(level.mean(), 0.1, 0.005);
  EXPECT_NEAR(told_noise / noise.variance(), 1, 0.35) << "single pixels would make it 1/64";
  EXPECT_NEAR(told_bias / bias.variance(), 1, 0.35);
  EXPECT_NEAR(told_level / level.variance(), 1, 0.35);
}

TEST(Measurement, ScalesAreThoseOfTheFrameError) {
  // By hand, one column of three pixels: levels 1, 2, 6; frame mean 3.
  const double floor = 3 * kErrorFloor;
  const Image image{1, 3, {1, 1, 1, 1, 2, 3, 6, 6, 6}};
  const std::vector<double> scales = squared_scales(image);
  ASSERT_EQ(scales.size(), 3u);
  EXPECT_NEAR(scales[0], 1.5 * 1.5 + floor * floor, 1e-12);
  EXPECT_NEAR(scales[1], 3.0 * 3.0 + floor * floor, 1e-12);
  EXPECT_NEAR(scales[2], 4.0 * 4.0 + floor * floor, 1e-12);
  EXPECT_TRUE(squared_scales({1, 1, {0, 0, 0}}).empty());
}

TEST(Measurement, NoiseAndBiasAreWithoutBiasThemselves) {
  const std::vector<double> scales = squared_scales(exact());
  const double unit = relative_unit(scales);
  RunningStatistics bias, noise, level;
  for (uint32_t seed = 1; seed <= testing::run_samples(200u); ++seed) {
    const Trial t = trial(testing::run_seed(seed), 0.1, 0.4, scales);
    bias.add(t.bias.value);
    noise.add(t.noise);
    level.add(t.level.value);
  }
  const auto squared_bias_test = z_test(bias, 0.1 * 0.1 * unit, {.slack = 1e-6});
  const auto noise_test = z_test(noise, 0.4 * 0.4 / 4 * unit, {.slack = 1e-6});
  // The quotient of two means is itself biased by the reference's relative variance, 1e-6 here.
  const auto level_test = z_test(level, 0.1, {.slack = 1e-5});
  EXPECT_TRUE(plausible(squared_bias_test));
  EXPECT_TRUE(plausible(noise_test));
  EXPECT_TRUE(plausible(level_test));
}

TEST(Measurement, IntervalsOfNoBiasHoldZeroInNineteenOfTwenty) {
  const std::vector<double> scales = squared_scales(exact());
  constexpr int kTrials = 1000;
  int held = 0, level_held = 0;
  for (uint32_t seed = 1; seed <= kTrials; ++seed) {
    const Trial t = trial(testing::run_seed(1000 + seed), 0, 0.4, scales);
    held += t.bias.low <= 0 && t.bias.high >= 0;
    level_held += t.level.low <= 0 && t.level.high >= 0;
  }
  const double sigma = std::sqrt(kTrials * 0.95 * 0.05);
  EXPECT_TRUE(plausible(testing::z_test(held, sigma, 0.95 * kTrials)));
  EXPECT_TRUE(plausible(testing::z_test(level_held, sigma, 0.95 * kTrials)));
}

TEST(Measurement, IntervalsOfABiasHoldItAtLeastAsOften) {
  const std::vector<double> scales = squared_scales(exact());
  const double expected = 0.05 * 0.05 * relative_unit(scales);
  int held = 0;
  for (uint32_t seed = 1; seed <= 300; ++seed) {
    const Trial t = trial(5000 + seed, 0.05, 0.2, scales);
    held += t.bias.low <= expected && t.bias.high >= expected;
  }
  EXPECT_GE(held, 0.95 * 300 - 3 * std::sqrt(300 * 0.95 * 0.05));
}

TEST(Measurement, ALoneReplicaIsLeftOut) {
  std::mt19937 random(3);
  std::vector<ReplicaGroup> groups{group_of(random, 0, 0.2, 4, 2)};
  const PooledMean two = pool(groups);
  groups.push_back(group_of(random, 5, 0.2, 64, 1));
  const PooledMean three = pool(groups);
  EXPECT_EQ(three.samples, 8);
  EXPECT_EQ(two.mean, three.mean);
  EXPECT_TRUE(pool({}).mean.empty());
}

}  // namespace
}  // namespace alabaster::tradeoff
