#include "core/convergence/sample_allocation.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/convergence/pixel_group.h"
#include "core/sampling/pixel_sampler.h"

namespace alabaster {
namespace {

constexpr PixelRect kWindows[] = {{0, 0, 6, 4}, {-3, 5, 4, 10}, {1, 1, 2, 9}, {7, -2, 8, -1}};

TEST(SampleAllocation, HandlesOddAndTinyWindowsAndBlackFrames) {
  for (const PixelRect& window : kWindows) {
    Film film(window, 0);
    for (const float light : {0.0f, 1.0f}) {
      FilmTile tile = FilmTile(size_t(window.width()) * size_t(window.height()), 0);
      for (size_t i = 0; i < size_t(window.width()) * size_t(window.height()); ++i)
        for (uint32_t s = 0; s < kPilotSamples; ++s) {
          FilmSample sample;
          sample.color = Rgb(light * float((i * 7 + s * s) % 5));
          tile.add(i, sample);
        }
      film.store_tile(0, tile);
      const size_t pixels = film.noise().size();
      const SampleAllocation allocation(film, std::vector<uint32_t>(pixels, 3), 64);
      for (size_t i = 0; i < pixels; ++i) {
        EXPECT_EQ(allocation.samples(i, 10), 10u) << "the pilot is the same for all";
        EXPECT_GE(allocation.samples(i, 64), kPilotSamples);
        EXPECT_LE(allocation.samples(i, 64), kPilotSamples + 8 * 48u);
      }
    }
  }
}

// A pilot of 24 x 24 pixels. Those left of `x_noisy` have samples of 0 or 2, the others of 0.9 or 1.1, by chance.
SampleAllocation allocate(int x_noisy, const std::vector<uint32_t>& rays) {
  Film film({0, 0, 24, 24}, 0);
  FilmTile tile(24 * 24, 0);
  for (size_t i = 0; i < 24 * 24; ++i)
    for (uint32_t s = 0; s < kPilotSamples; ++s) {
      const float noise = static_cast<int>(i % 24) < x_noisy ? 1 : 0.1f;
      FilmSample sample;
      sample.color = Rgb(hash32(static_cast<uint32_t>(i) * kPilotSamples + s) & 1 ? 1 + noise : 1 - noise);
      tile.add(i, sample);
    }
  film.store_tile(0, tile);
  return {film, rays, 64};
}

double mean_samples(const SampleAllocation& allocation, int x0, int x1) {
  double sum = 0;
  for (int y = 0; y < 24; ++y)
    for (int x = x0; x < x1; ++x) sum += allocation.samples(static_cast<size_t>(24 * y + x), 64);
  return sum / (24 * (x1 - x0));
}

TEST(SampleAllocation, NoisyPixelsGetMoreSamples) {
  const SampleAllocation allocation = allocate(8, std::vector<uint32_t>(24 * 24, 10));
  EXPECT_GT(mean_samples(allocation, 0, 6), 3 * mean_samples(allocation, 12, 24));
  EXPECT_NEAR(mean_samples(allocation, 0, 24), 64, 1);
}

// One pixel that met a bright path does not take the samples of those around it.
TEST(SampleAllocation, OneBrightSampleMovesFewSamples) {
  Film film({0, 0, 24, 24}, 0);
  FilmTile tile(24 * 24, 0);
  for (size_t i = 0; i < 24 * 24; ++i)
    for (uint32_t s = 0; s < kPilotSamples; ++s) {
      FilmSample sample;
      sample.color = Rgb(hash32(static_cast<uint32_t>(i) * kPilotSamples + s) & 1 ? 1.1f : 0.9f);
      if (i == 12 * 24 + 12 && s == 5) sample.color = Rgb(20.0f);
      tile.add(i, sample);
    }
  film.store_tile(0, tile);
  const SampleAllocation allocation(film, std::vector<uint32_t>(24 * 24, 10), 64);
  double far = 0;  // samples of pixels that are far from it, but of groups that it allocates for
  double count = 0;
  for (int y = 0; y < 24; ++y)
    for (int x : {0, 1, 2, 21, 22, 23})
      if (allocates(pixel_group(12, 12), pixel_group(x, y)))
        far += allocation.samples(static_cast<size_t>(24 * y + x), 64), ++count;
  far /= count;
  EXPECT_LT(far, 64);
  EXPECT_GT(far, 45);
}

// Equal noise, four times the cost: half the samples.
TEST(SampleAllocation, CostlyPixelsGetFewerSamples) {
  std::vector<uint32_t> rays(24 * 24, 10);
  for (size_t i = 0; i < rays.size(); ++i)
    if (i % 24 >= 12) rays[i] = 40;
  const SampleAllocation allocation = allocate(24, rays);
  EXPECT_NEAR(mean_samples(allocation, 0, 8) / mean_samples(allocation, 16, 24), 2, 0.3);
  EXPECT_NEAR(mean_samples(allocation, 0, 24), 64, 1);
}

}  // namespace
}  // namespace alabaster
