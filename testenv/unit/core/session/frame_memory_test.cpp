#include "core/session/frame_memory.h"

#include <gtest/gtest.h>

#include "testenv/support/scene_builder.h"

namespace alabaster {
namespace {

constexpr int kSide = 128;
constexpr uint32_t kAovs = aov_bit(Aov::color) | aov_bit(Aov::normal) | aov_bit(Aov::depth);

RenderRequest request_of(const RenderSettings& settings) {
  RenderRequest request = testing::mixed_request(settings.samples);
  request.settings = settings;
  request.settings.threads = 2;
  request.settings.max_depth = 1;
  request.settings.subsurface = SubsurfaceMode::lambert;
  request.width = request.height = kSide;
  request.data_window = {0, 0, kSide, kSide};
  request.aovs = kAovs;
  return request;
}

size_t held_by(const Film& film) {
  size_t bytes = 0;
  for (int t = 0; t < film.tile_count(); ++t) {
    FilmTile tile = film.load_tile(t);
    for (const auto& plane : tile.planes()) bytes += plane.size();
  }
  return bytes;
}

struct Case {
  const char* name;
  RenderSettings settings;
};

// A part keeps sums at powers of two, an adaptive frame its rays and rates, a frame with a target error a second film.
std::vector<Case> cases() {
  std::vector<Case> all(6);
  for (Case& c : all) c.settings.samples = 8;
  all[0].name = "even";
  all[1].name = "part 1:8", all[1].settings.first_sample = 1;
  all[2].name = "part 3:64", all[2].settings.first_sample = 3, all[2].settings.samples = 64;
  all[3].name = "adaptive", all[3].settings.adaptive = true, all[3].settings.samples = 32;
  all[4].name = "target error", all[4].settings.target_error = 0.1f, all[4].settings.samples = 64;
  all[5].name = "adaptive to an error", all[5].settings = all[4].settings, all[5].settings.adaptive = true;
  return all;
}

TEST(FrameMemory, IsThatOfTheFilm) {
  for (const Case& c : cases()) {
    const RenderRequest request = request_of(c.settings);
    const auto film = testing::render(request);
    EXPECT_EQ(film_bytes(film->data_window(), film->aovs(), film->extras()), held_by(*film)) << c.name;
    EXPECT_EQ(film->extras(), film_extras(c.settings)) << c.name;
    EXPECT_GE(frame_bytes(request.data_window, film->aovs(), c.settings), held_by(*film)) << c.name;
  }
}

// A table of factors by number of samples.
TEST(FrameMemory, GrowsWithTheNumberOfSamples) {
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
