#include "core/film/pixel_noise.h"

#include <gtest/gtest.h>

#include <cmath>

namespace alabaster {
namespace {

TEST(PixelNoise, UsesTheTailOnceItIsHalfAsLong) {
  for (const uint32_t samples : {3u, 6u, 7u, 12u, 15u, 24u}) EXPECT_TRUE(PixelNoise::uses_tail(samples)) << samples;
  for (const uint32_t samples : {0u, 1u, 2u, 4u, 5u, 8u, 11u, 16u, 23u})
    EXPECT_FALSE(PixelNoise::uses_tail(samples)) << samples;
}

// Independent samples of variance 1: halves of m differ by 4 / m squared, m and r samples by 1 / m + 1 / r.
TEST(PixelNoise, DeviationOfIndependentSamplesFallsWithTheirRoot) {
  EXPECT_EQ((PixelNoise{.samples = 1, .latest = 9}).deviation(), 0);
  for (const uint32_t n : {2u, 8u, 11u}) {
    const double m = std::bit_floor(n);
    EXPECT_FLOAT_EQ((PixelNoise{.samples = n, .latest = 4 / m, .tail = 9}).deviation(),
                    1 / std::sqrt(static_cast<float>(n)));
  }
  EXPECT_FLOAT_EQ((PixelNoise{.samples = 12, .latest = 9, .tail = 1 / 8.0 + 1 / 4.0}).deviation(),
                  1 / std::sqrt(12.0f));
}

}  // namespace
}  // namespace alabaster
