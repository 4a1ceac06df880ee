#include "core/convergence/sample_allocation.h"

#include <gtest/gtest.h>

namespace alabaster {
namespace {

constexpr PixelRect kWindows[] = {{0, 0, 6, 4}, {-3, 5, 4, 10}, {1, 1, 2, 9}, {7, -2, 8, -1}};

TEST(SampleAllocation, OddAndTinyWindowsAndBlackFramesAreDealtOut) {
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
      film.store_tile(0, std::move(tile));
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

}  // namespace
}  // namespace alabaster
