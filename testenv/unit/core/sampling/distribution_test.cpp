#include "core/sampling/distribution.h"

#include <gtest/gtest.h>

#include "core/sampling/pixel_sampler.h"

namespace alabaster {
namespace {

TEST(Distribution1D, SamplesLieInTheirCellAndNeverInEmptyOnes) {
  for (size_t n : {1u, 3u, 7u, 1000u, 4097u}) {
    std::vector<float> weights(n);
    Rng rng(n, 1);
    for (float& w : weights) w = rng.uniform() < 0.5f ? 0 : std::exp(20 * rng.uniform());
    weights[n / 2] = 1;
    const Distribution1D d(weights);
    std::vector<float> begins(n + 1);  // exact: whole multiples of 2^-24
    for (size_t i = 0; i < n; ++i) begins[i + 1] = begins[i] + d.probability(i);
    for (int i = 0; i < 20000; ++i) {
      const float u = i == 0 ? 0 : i == 1 ? kOneMinusEpsilon : rng.uniform();
      const auto s = d.sample(u);
      ASSERT_GT(weights[s.index], 0);
      ASSERT_TRUE(begins[s.index] <= u && u < begins[s.index + 1]) << n << ' ' << u;
      ASSERT_GT(s.pdf, 0);
      ASSERT_EQ(d.pdf(s.x), s.pdf) << n << ' ' << u;
      ASSERT_TRUE(s.x >= 0 && s.x < 1 && s.remapped >= 0 && s.remapped < 1);
    }
  }
}

TEST(Distribution1D, EveryPositiveWeightKeepsAChance) {
  for (size_t heavy : {size_t(0), size_t(500), size_t(999)}) {
    std::vector<float> weights(1000, 1e-30f);
    weights[heavy] = 1e30f;
    weights[3] = 0;
    const Distribution1D d(weights);
    float sum = 0;
    for (size_t i = 0; i < weights.size(); ++i) {
      EXPECT_EQ(d.probability(i) > 0, weights[i] > 0) << i;
      sum += d.probability(i);
    }
    EXPECT_EQ(sum, 1);  // whole steps: exact
  }
}

TEST(Distribution1D, WithoutWeightIsUniform) {
  const Distribution1D d(std::vector<float>(5, 0.0f));
  EXPECT_EQ(d.sum(), 0);
  for (size_t i = 0; i < 5; ++i) EXPECT_NEAR(d.probability(i), 0.2f, 1e-7f);
  EXPECT_EQ(d.sample(0.5f).index, 2u);
  EXPECT_EQ(Distribution1D().size(), 0u);
}

TEST(Distribution2D, HugeWeightsDoNotOverflow) {
  const Distribution2D d(std::vector<float>(16, 3e38f), 8, 2);
  for (size_t y = 0; y < 2; ++y)
    for (size_t x = 0; x < 8; ++x) EXPECT_NEAR(d.probability(x, y), 1.0 / 16, 1e-7);
  EXPECT_EQ(d.sample({0.3f, 0.7f}).y, 1u);
}

}  // namespace
}  // namespace alabaster
