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

// Independent samples of variance 1: the squared difference of halves of m is 4 / m, of m and r samples 1 / m + 1 / r.
TEST(PixelNoise, DeviationOfIndependentSamplesFallsWithTheirRoot) {
  EXPECT_EQ((PixelNoise{.samples = 1, .latest = 9}).deviation(), 0);
  for (const uint32_t n : {2u, 8u, 11u}) {
    const float m = static_cast<float>(std::bit_floor(n));
    EXPECT_FLOAT_EQ((PixelNoise{.samples = n, .latest = 2 / std::sqrt(m), .tail = 9}).deviation(),
                    1 / std::sqrt(static_cast<float>(n)));
  }
  EXPECT_FLOAT_EQ((PixelNoise{.samples = 12, .latest = 9, .tail = std::sqrt(1 / 8.0f + 1 / 4.0f)}).deviation(),
                  1 / std::sqrt(12.0f));
}

}  // namespace
}  // namespace alabaster
