#include "core/film/sample_sum.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <vector>

namespace alabaster {
namespace {

bool same_bits(const RgbSum& a, const RgbSum& b) {
  return std::memcmp(&a, &b, sizeof a) == 0;
}

RgbSum sum_of(const std::vector<float>& values) {
  RgbSum sum;
  for (const float v : values) sum.add({v, -v, 1});
  return sum;
}

// Floats of all exponents from 2^-`range` to 2^`range`; some zero, some negative.
std::vector<float> random_floats(size_t count, int range, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<int> exponent(-range, range);
  std::uniform_real_distribution<float> mantissa(0.5f, 1);
  std::vector<float> values(count);
  for (float& v : values) {
    v = std::ldexp(mantissa(random), exponent(random));
    if (random() % 8 == 0) v = 0;
    if (random() % 8 == 0) v = -v;
  }
  return values;
}

TEST(RgbSum, DoesNotDependOnTheOrder) {
  for (const int range : {2, 20, 60, 120}) {
    std::vector<float> values = random_floats(300, range, 7);
    const RgbSum first = sum_of(values);
    std::mt19937 random(1);
    for (int i = 0; i < 200; ++i) {
      std::shuffle(values.begin(), values.end(), random);
      ASSERT_TRUE(same_bits(first, sum_of(values))) << range;
    }
  }
}

TEST(RgbSum, SumOfPartsIsThatOfTheWhole) {
  std::mt19937 random(3);
  for (int i = 0; i < 300; ++i) {
    const std::vector<float> values = random_floats(200, i % 120, static_cast<unsigned>(random()));
    RgbSum parts[4];
    for (const float v : values) parts[random() % 4].add({v, -v, 1});
    std::shuffle(std::begin(parts), std::end(parts), random);
    RgbSum sum;
    for (const RgbSum& part : parts) sum.add(part);
    ASSERT_TRUE(same_bits(sum, sum_of(values))) << i;
  }
}

// The error of sums of doubles in sequence is the yardstick. long double has 11 bits more.
TEST(RgbSum, IsCloserThanSumsOfDoubles) {
  std::mt19937 random(5);
  std::lognormal_distribution<float> fireflies(0, 3);
  double worst = 0, worst_double = 0;
  for (int run = 0; run < 4; ++run) {
    RgbSum sum;
    double plain = 0;
    long double exact = 0;
    for (int i = 0; i < 1000000; ++i) {
      const float v = fireflies(random);
      sum.add(Rgb(v));
      plain += v;
      exact += v;
    }
    worst = std::max(worst, static_cast<double>(std::abs((sum.value()[0] - exact) / exact)));
    worst_double = std::max(worst_double, static_cast<double>(std::abs((plain - exact) / exact)));
  }
  EXPECT_LE(worst, 0x1p-52);
  EXPECT_LT(worst, worst_double);
}

TEST(RgbSum, HoldsAllFloats) {
  using Limits = std::numeric_limits<float>;
  for (const float v : {Limits::denorm_min(), Limits::min(), 1e-30f, 0.1f, 1.0f, 1e30f, Limits::max()}) {
    RgbSum sum;
    sum.add({v, -v, 0});
    EXPECT_EQ(sum.value(), (std::array<double, 3>{v, -double(v), 0})) << v;
    EXPECT_TRUE(sum.is_valid());
    for (int i = 1; i < 1 << 20; ++i) sum.add({v, -v, 0});
    EXPECT_EQ(sum.value(), (std::array<double, 3>{v * 0x1p20, -double(v) * 0x1p20, 0})) << v;
    EXPECT_TRUE(sum.is_valid());
  }
}

TEST(RgbSum, KeepsALargeAndASmallValueApart) {
  RgbSum sum;
  sum.add(Rgb(1));
  sum.add(Rgb(0x1p31f));
  sum.add(Rgb(-0x1p31f));
  EXPECT_EQ(sum.value()[0], 1);
}

TEST(RgbSum, LeavesOutWhatIsNotFinite) {
  RgbSum sum;
  sum.add({std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity(),
           std::numeric_limits<float>::quiet_NaN()});
  EXPECT_EQ(sum.value(), (std::array<double, 3>{0, 0, 0}));
}

TEST(RgbSum, KnowsBitsThatNoSumHas) {
  RgbSum sum;
  auto* const bytes = reinterpret_cast<unsigned char*>(&sum);
  EXPECT_TRUE(sum.is_valid());
  bytes[7] = 0x7f;  // a bin with more than any number of samples gives
  EXPECT_FALSE(sum.is_valid());
  sum = RgbSum();
  bytes[9 * sizeof(int64_t)] = 9;  // a bin above that of the largest float
  EXPECT_FALSE(sum.is_valid());
}

TEST(UnitSum, IsExactForNumbersNearOne) {
  UnitSum sum, part, zero;
  for (int i = 0; i < 1 << 20; ++i) (i % 3 ? sum : part).add(0.7f);
  sum.add(part);
  EXPECT_EQ(sum.value(), double(0.7f) * 0x1p20);
  for (const float v : {1e30f, -std::numeric_limits<float>::infinity(), std::nanf("")}) zero.add(v);
  EXPECT_EQ(zero.value(), 0);
}

}  // namespace
}  // namespace alabaster
