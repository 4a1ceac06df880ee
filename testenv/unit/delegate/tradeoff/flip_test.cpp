#include "delegate/tradeoff/flip.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>

namespace alabaster::tradeoff {
namespace {

using Triple = std::array<double, 3>;

Image picture(int width, int height, const std::function<double(int, int, int)>& value) {
  Image image{width, height, {}};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c) image.rgb.push_back(float(value(x, y, c)));
  return image;
}
Image uniform(int width, int height, const Triple& srgb) {
  return picture(width, height, [&](int, int, int c) { return srgb[size_t(c)]; });
}
Image noisy(double amplitude, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> u(-1, 1);
  return picture(64, 48, [&](int x, int y, int) { return 0.2 + 0.005 * x + 0.006 * y + amplitude * u(random); });
}

// The exponent 1 - sqrt(feature difference) makes 3e-4 of one rounding error, hence the tolerance.
constexpr double kRounding = 5e-4;

TEST(Flip, EqualPicturesDoNotDiffer) {
  const Image image = noisy(0.3, 1);
  const FlipDifference difference = flip_difference(image, image);
  EXPECT_EQ(difference.mean, 0);
  EXPECT_EQ(difference.map, std::vector<float>(64 * 48, 0.0f));
}

TEST(Flip, IsSymmetric) {
  const Image a = noisy(0.2, 1), b = noisy(0.2, 2);
  const FlipDifference there = flip_difference(a, b), back = flip_difference(b, a);
  EXPECT_GT(there.mean, 0.1);
  EXPECT_EQ(there.map, back.map);
  EXPECT_EQ(there.mean, back.mean);
}

TEST(Flip, BrokenValuesAreBlackOrClamped) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN(), kInf = std::numeric_limits<float>::infinity();
  Image broken = noisy(0.1, 1), repaired = broken;
  const float bad[] = {kNan, kInf, -kInf, -3, 7}, good[] = {0, 1, 0, 0, 1};
  for (size_t i = 0; i < 5; ++i) {
    broken.rgb[700 * i + 11] = bad[i];
    repaired.rgb[700 * i + 11] = good[i];
  }
  EXPECT_EQ(flip_difference(broken, repaired).mean, 0);
  const Image other = noisy(0.1, 2);
  EXPECT_EQ(flip_difference(other, broken).map, flip_difference(other, repaired).map);
  EXPECT_TRUE(std::isfinite(flip_difference(other, broken).mean));
}

TEST(Flip, SmallestPicturesHaveADifference) {
  const Triple a = {0.2, 0.5, 0.6}, b = {0.3, 0.5, 0.4};
  const double of_a_large_one = flip_difference(uniform(40, 40, a), uniform(40, 40, b)).mean;
  EXPECT_GT(of_a_large_one, 0.1);
  for (const auto& [width, height] : {std::pair{1, 1}, {1, 40}, {40, 1}, {2, 3}})
    EXPECT_NEAR(flip_difference(uniform(width, height, a), uniform(width, height, b)).mean, of_a_large_one, kRounding);
}

TEST(Flip, IncomparablePicturesHaveNoDifference) {
  const Image image = uniform(4, 3, {0, 0, 0});
  Image torn = image;
  torn.rgb.pop_back();
  for (const FlipDifference& d :
       {flip_difference(image, uniform(3, 4, {0, 0, 0})), flip_difference(Image{}, Image{}),
        flip_difference(image, torn), flip_difference(image, image, 0), flip_difference(image, image, -67),
        flip_difference(image, image, 1e9f), flip_difference(image, image, std::nanf(""))}) {
    EXPECT_TRUE(d.map.empty());
    EXPECT_TRUE(std::isnan(d.mean));
  }
  EXPECT_EQ(flip_difference(image, image, 1).mean, 0);
  EXPECT_EQ(flip_difference(image, image, 1000).mean, 0);
}

// Results of the authors' own program (flip-evaluator 1.7 of the Python Package Index, LDR) for waves that move or
// weaken.
TEST(Flip, AgreesWithTheAuthorsProgram) {
  const auto waves = [](double shift, double amplitude) {
    return picture(64, 48, [=](int px, int y, int c) {
      const double x = px + shift;
      if (c == 0) return 0.5 + amplitude * std::sin(0.37 * x + 0.05 * y);
      if (c == 1) return 0.45 + amplitude * std::sin(0.21 * y - 0.11 * x);
      return 0.5 + amplitude * std::cos(0.13 * x * y / 16);
    });
  };
  struct Case {
    double shift, amplitude;
    float pixels_per_degree;
    double mean, first, middle, last;  // of the map: pixels (0, 0), (30, 20), (63, 47)
  };
  for (const Case& c : {Case{0, 0.3, 67, 0.364374, 0.378176, 0.486491, 0.260179},
                        {0, 0.3, 30, 0.366928, 0.339932, 0.489793, 0.248738},
                        {1, 0.4, 67, 0.293079, 0.314565, 0.379827, 0.430436},
                        {1, 0.4, 30, 0.312139, 0.311478, 0.394554, 0.434660},
                        {5, 0.4, 67, 0.759142, 0.578578, 0.960594, 0.640045},
                        {5, 0.4, 30, 0.798674, 0.642407, 0.958883, 0.603287}}) {
    const FlipDifference d = flip_difference(waves(0, 0.4), waves(c.shift, c.amplitude), c.pixels_per_degree);
    EXPECT_NEAR(d.mean, c.mean, 1e-4);
    EXPECT_NEAR(double(d.map.front()), c.first, kRounding);
    EXPECT_NEAR(double(d.map[20 * 64 + 30]), c.middle, kRounding);
    EXPECT_NEAR(double(d.map.back()), c.last, kRounding);
  }
}

}  // namespace
}  // namespace alabaster::tradeoff
