#include "core/sampling/pixel_sampler.h"

#include <gtest/gtest.h>

#include <set>
#include <vector>

namespace alabaster {
namespace {

// Is the run of 2^m samples from `first` on a (0,m,2)-net in dimensions a and b: one point in every box of 2^i x 2^j
// intervals, i + j = m?
bool is_net(uint32_t seed, uint32_t first, int m, size_t a, size_t b) {
  const auto n = uint32_t(1) << m;
  for (int i = 0; i <= m; ++i) {
    std::vector<bool> taken(n);
    for (uint32_t k = 0; k < n; ++k) {
      const auto u = PixelSampler(seed, first + k).draw(Dimension::bsdf, 3);
      const auto x = static_cast<uint32_t>(u[a] * static_cast<float>(1u << i));
      const auto y = static_cast<uint32_t>(u[b] * static_cast<float>(1u << (m - i)));
      const uint32_t box = (x << (m - i)) | y;
      if (taken[box]) return false;
      taken[box] = true;
    }
  }
  return true;
}

TEST(PixelSampler, FirstTwoDimensionsAreNets) {
  for (uint32_t seed : {1u, 0xdeadbeefu, 77u})
    for (int m : {1, 2, 5, 8, 10}) EXPECT_TRUE(is_net(seed, 0, m, 0, 1)) << seed << ' ' << m;
}

TEST(PixelSampler, EveryAlignedRunIsANetUpToTheLastIndex) {
  for (uint32_t first : {256u, 0x01000000u, 0x7fffff00u, 0x80000000u, 0xffffff00u})
    EXPECT_TRUE(is_net(5, first, 8, 0, 1)) << first;
}

TEST(PixelSampler, EachDimensionIsStratifiedAndNoPairIsCorrelated) {
  constexpr uint32_t kCount = 1024;
  for (uint32_t seed : {1u, 9u}) {
    std::array<std::vector<int>, 4> strata;
    std::array<std::array<std::vector<int>, 4>, 4> squares;  // 16 x 16 boxes of expectation 4
    for (auto& s : strata) s.resize(kCount);
    for (auto& row : squares)
      for (auto& s : row) s.resize(256);
    for (uint32_t k = 0; k < kCount; ++k) {
      const auto u = PixelSampler(seed, k).draw(Dimension::light, 0);
      for (size_t a = 0; a < 4; ++a) {
        ++strata[a][static_cast<size_t>(u[a] * kCount)];
        for (size_t b = 0; b < a; ++b)
          ++squares[a][b][static_cast<size_t>(u[a] * 16) * 16 + static_cast<size_t>(u[b] * 16)];
      }
    }
    for (size_t a = 0; a < 4; ++a) {
      for (int count : strata[a]) ASSERT_EQ(count, 1) << a;
      // The worst pair of these dimensions has quality t = 2: boxes of 2^-(m-t) hold exactly 2^t points, m = 10.
      for (size_t b = 0; b < a; ++b)
        for (int count : squares[a][b]) ASSERT_EQ(count, 4) << a << ' ' << b;
    }
  }
}

// Aligned runs stay nets however they are scrambled, but the scrambles must differ: pixels, purposes and depths apart
// share no numbers.
TEST(PixelSampler, BlocksAreIndependent) {
  std::set<float> seen;
  size_t drawn = 0;
  for (int x = 0; x < 8; ++x)
    for (auto purpose : {Dimension::film_lens, Dimension::bsdf, Dimension::light, Dimension::exit_light})
      for (uint32_t depth = 0; depth < 8; ++depth) {
        for (float u : PixelSampler(pixel_seed(x, 0, 0, 0), 0).draw(purpose, depth)) seen.insert(u);
        drawn += 4;
      }
  // 1024 numbers of 2^24: half a coincidence expected in ten thousand.
  EXPECT_GE(seen.size(), drawn - 2);

  // The correlation of two blocks over the samples of a pixel: standard deviation 1/sqrt(n) if independent.
  double sum = 0;
  constexpr int kCount = 4096;
  for (uint32_t k = 0; k < kCount; ++k) {
    const PixelSampler s(pixel_seed(3, 4, 0, 0), k);
    sum += (static_cast<double>(s.draw(Dimension::bsdf, 0)[0]) - 0.5) *
           (static_cast<double>(s.draw(Dimension::bsdf, 1)[0]) - 0.5) * 12;
  }
  EXPECT_LT(std::abs(sum / kCount), 4 / std::sqrt(static_cast<double>(kCount)));
}

// An Owen scramble makes each number uniform over seeds, wherever the point was.
TEST(PixelSampler, NumbersAreUniformOverPixels) {
  constexpr int kBins = 64, kPixels = 1 << 16;
  for (uint32_t index : {0u, 1u, 0x80000000u}) {
    std::array<std::array<int, kBins>, 4> counts{};
    for (int i = 0; i < kPixels; ++i) {
      const auto u = PixelSampler(pixel_seed(i & 255, i >> 8, 0, 0), index).draw(Dimension::film_lens, 0);
      for (size_t d = 0; d < 4; ++d) ++counts[d][static_cast<size_t>(u[d] * kBins)];
    }
    for (size_t d = 0; d < 4; ++d) {
      double statistic = 0;
      const double expected = static_cast<double>(kPixels) / kBins;
      for (int c : counts[d]) statistic += (c - expected) * (c - expected) / expected;
      // Chi-square with 63 degrees of freedom: mean 63, standard deviation 11.2; 126 is exceeded with chance 4e-6.
      EXPECT_LT(statistic, 126) << index << ' ' << d;
    }
  }
}

TEST(UnitFloat, NeverReachesOne) {
  EXPECT_EQ(to_unit_float(0), 0);
  EXPECT_EQ(to_unit_float(0xffffffffu), kOneMinusEpsilon);
}

// First outputs of the generator's published demonstration (seed 42, stream 54).
TEST(Rng, IsPcg32) {
  Rng rng(42, 54);
  for (uint32_t expected : {0xa15c02b7u, 0x7b47f409u, 0xba1d3330u, 0x83d2f293u, 0xbfa4784bu, 0xcbed606eu})
    EXPECT_EQ(rng.next(), expected);
}

}  // namespace
}  // namespace alabaster
