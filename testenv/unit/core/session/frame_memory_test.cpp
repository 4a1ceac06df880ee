#include "core/session/frame_memory.h"

#include <gtest/gtest.h>

#include "core/convergence/frame_error.h"
#include "testenv/support/frame_memory_cases.h"

namespace alabaster {
namespace {

size_t held_by(const Film& film) {
  size_t bytes = 0;
  for (int t = 0; t < film.tile_count(); ++t) {
    FilmTile tile = film.load_tile(t);
    for (const auto& plane : tile.planes()) bytes += plane.size();
  }
  return bytes;
}

TEST(FilmMemory, BytesAreThoseOfTheFilm) {
  for (const testing::FrameMemoryCase& c : testing::frame_memory_cases()) {
    const RenderRequest request = testing::frame_memory_request(c.settings);
    const auto film = testing::render(request);
    EXPECT_EQ(film_bytes(film->data_window(), film->aovs(), film->extras()), held_by(*film)) << c.name;
    EXPECT_EQ(film->extras(), film_extras(c.settings)) << c.name;
    EXPECT_GE(frame_bytes(request.data_window, film->aovs(), c.settings), held_by(*film)) << c.name;
  }
}

// The noise of a pixel has 24 bytes, and its two scales have 16. Tables by number of samples, and what threads compute
// with, do not grow with the frame.
TEST(FilmMemory, ErrorEstimateTakesAThirdOfTheFilm) {
  EXPECT_LE(frame_error_bytes({0, 0, 1000, 1000}, 64), 40'000'000u + 2000);
}

// A table of factors by number of samples.
TEST(FilmMemory, GrowsWithTheNumberOfSamples) {
  RenderSettings settings;
  settings.samples = 1 << 20;
  const size_t bytes = frame_bytes({0, 0, 1, 1}, 0, settings);
  EXPECT_GE(bytes, sizeof(double) << 20);
  settings.adaptive = true;
  EXPECT_GE(frame_bytes({0, 0, 1, 1}, 0, settings), (sizeof(double) << 20) * 8);
  EXPECT_EQ(frame_bytes({5, 5, 5, 9}, ~0u, settings), 0u);
}

}  // namespace
}  // namespace alabaster
