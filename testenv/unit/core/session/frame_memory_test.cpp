#include "core/session/frame_memory.h"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace alabaster
