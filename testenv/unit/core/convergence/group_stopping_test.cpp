#include "core/convergence/group_stopping.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <utility>

#include "core/sampling/pixel_sampler.h"
#include "testenv/support/relative_error.h"

namespace alabaster {
namespace {

FrameError error_of(double relative_rmse) {
  FrameError error;
  error.known = true;
  error.relative_rmse = relative_rmse;
  return error;
}

// Pairs of groups end each other; one that has ended is traced on while the other needs it.
TEST(GroupStopping, AnotherGroupsErrorEndsAGroup) {
  GroupStopping stopping;
  EXPECT_EQ(stopping.decide({error_of(3), error_of(3), error_of(3), error_of(3)}, 1), 0u);
  EXPECT_EQ(stopping.decide({error_of(1), error_of(3), error_of(3), error_of(3)}, 1), 0b0100u);
  EXPECT_EQ(stopping.groups_to_trace(), kAllPixelGroups);
  EXPECT_EQ(stopping.decide({error_of(1), error_of(3), error_of(1), error_of(3)}, 1), 0b0001u);
  EXPECT_EQ(stopping.groups_to_trace(), 0b1010u);
  EXPECT_EQ(stopping.decide({error_of(3), error_of(1), error_of(3), error_of(1)}, 1), 0b1010u);
  EXPECT_TRUE(stopping.all_ended());
  EXPECT_EQ(stopping.groups_to_trace(), 0u);
}

// The doubt about an error counts as noise where it ends a group, but not where the end is predicted: it falls faster.
TEST(GroupStopping, ErrorOfGroupsIsReported) {
  GroupStopping stopping;
  FrameError doubtful = error_of(3);
  doubtful.high = 7;
  EXPECT_EQ(stopping.decide({doubtful, error_of(7), doubtful, error_of(7)}, 4.9), 0u);
  EXPECT_DOUBLE_EQ(stopping.error(), std::sqrt((3 * 3 + 7 * 7) / 2.0));
  EXPECT_EQ(stopping.decide({doubtful, error_of(7), doubtful, error_of(7)}, 5.1), 0b0101u);
}

TEST(GroupStopping, GroupWithoutAnotherDecidesByItself) {
  GroupStopping stopping;
  EXPECT_EQ(stopping.decide({error_of(3), FrameError{}, FrameError{}, error_of(1)}, 1), 0b1010u);
}

TEST(GroupStopping, ErrorChecksAreFixedBeforehand) {
  uint32_t check = 16;
  for (const uint32_t next : {18u, 20u, 22u, 24u, 27u, 30u, 33u}) EXPECT_EQ(check = next_error_check(check), next);
}

// Samples of pixels whose group is in `noisy` are 0 or 2 by chance, the others 1.
void fill(uint32_t samples, uint32_t noisy, Film* film) {
  FilmTile tile(64, 0);
  for (size_t i = 0; i < 64; ++i)
    for (uint32_t s = 0; s < samples; ++s) {
      const bool has_noise = noisy >> pixel_group(static_cast<int>(i % 8), static_cast<int>(i / 8)) & 1;
      FilmSample sample;
      sample.color = Rgb(has_noise ? static_cast<float>(hash32(static_cast<uint32_t>(64 * i) + s) & 2) : 1);
      tile.add(i, sample);
    }
  film->store_tile(0, tile);
}

TEST(GroupStopping, AnErrorThatIsNotKnownYetEndsNothing) {
  GroupStopping stopping;
  Film film({0, 0, 8, 8}, 0);
  fill(1, kAllPixelGroups, &film);
  stopping.update(film, film_noise(film), 0.1);
  EXPECT_EQ(stopping.ended(), 0u) << "one sample tells no error";
  stopping.update(film, NoiseImage{}, 0.1);
  EXPECT_EQ(stopping.ended(), 0u) << "an error that was not measured";
}

TEST(GroupStopping, GroupsThatEndedShowWhatTheyHadThen) {
  GroupStopping stopping;
  Film film({0, 0, 8, 8}, 0);
  fill(16, 0b1110, &film);
  stopping.update(film, film_noise(film), 0.1);
  EXPECT_EQ(stopping.groups_to_trace(), kAllPixelGroups) << "group 2 has ended, but 0 needs its error";
  fill(24, 0, &film);
  stopping.update(film, film_noise(film), 0.1);
  EXPECT_TRUE(stopping.all_ended());
  EXPECT_TRUE(stopping.show_ended(&film));
  EXPECT_TRUE(stopping.show_ended(&film)) << "again, which changes nothing";
  const auto samples = film.resolve_int(Aov::sample_count);
  const auto on = stopping.kept_film()->resolve_int(Aov::sample_count);
  for (int i = 0; i < 64; ++i) {
    const bool ended_first = pixel_group(i % 8, i / 8) == 2;
    EXPECT_EQ(samples[static_cast<size_t>(i)], ended_first ? 16 : 24);
    EXPECT_EQ(on[static_cast<size_t>(i)], ended_first ? 24 : 0) << "those that were traced on are kept";
  }
}

// Each plane of a pixel goes with it, and a checkpoint has the shape that it is read with.
TEST(GroupStopping, ThePixelsThatAreKeptHaveAllPlanesOfTheFilm) {
  const FilmExtras extras{true, {}};
  Film film({0, 0, 8, 8}, aov_bit(Aov::normal), extras);
  FilmTile tile = film.load_tile(0);
  for (size_t i = 0; i < 64; ++i)
    for (uint32_t s = 0; s < 16; ++s) {
      const bool has_noise = pixel_group(static_cast<int>(i % 8), static_cast<int>(i / 8)) != 0;
      FilmSample sample;
      sample.color = Rgb(has_noise ? static_cast<float>(hash32(static_cast<uint32_t>(64 * i) + s) & 2) : 1);
      tile.add(i, sample, nullptr, 3);
    }
  film.store_tile(0, tile);
  GroupStopping stopping;
  stopping.update(film, film_noise(film), 0.1);
  ASSERT_TRUE(stopping.kept_film());
  EXPECT_EQ(stopping.kept_film()->extras(), extras);
  const auto rays = stopping.kept_film()->rays();
  for (int i = 0; i < 64; ++i) EXPECT_EQ(rays[static_cast<size_t>(i)], pixel_group(i % 8, i / 8) == 2 ? 48u : 0u);
}

// Frames in which only some pixels have noise, in patterns as fine as a pixel: `has_noise(x, y)`.
double error_at_the_end(const std::function<bool(int, int)>& has_noise, double target) {
  constexpr int kSide = 32;
  Film film({0, 0, kSide, kSide}, 0);
  GroupStopping stopping;
  uint32_t n = 16;
  for (; n < 4096 && !stopping.all_ended(); n = next_error_check(n)) {
    film.change_tile(0, [&](FilmTile& tile) {
      for (size_t i = 0; i < size_t(kSide) * kSide; ++i)
        while (is_in(stopping.groups_to_trace(), int(i % kSide), int(i / kSide)) && tile.next_sample(i) < n) {
          const bool noisy = has_noise(int(i % kSide), int(i / kSide));
          const uint32_t chance = hash_combine(hash32(uint32_t(i)), tile.next_sample(i));
          FilmSample sample;
          sample.color = Rgb(noisy ? 2.0f * static_cast<float>(chance & 1) : 0.4f);
          tile.add(i, sample);
        }
    });
    stopping.update(film, film_noise(film), target);
  }
  EXPECT_TRUE(stopping.all_ended());
  stopping.show_ended(&film);
  std::vector<float> truth;
  for (int i = 0; i < kSide * kSide; ++i)
    for (int c = 0; c < 4; ++c) truth.push_back(has_noise(i % kSide, i / kSide) ? 1.0f : 0.4f);
  return std::sqrt(testing::relative_mse(film.resolve_float(Aov::color), truth, kSide, kSide));
}

TEST(GroupStopping, NoPatternOfAPictureHidesItsNoise) {
  const std::pair<const char*, std::function<bool(int, int)>> patterns[] = {
      {"columns", [](int x, int) { return x % 2 == 0; }},
      {"rows", [](int, int y) { return y % 2 == 1; }},
      {"chessboard", [](int x, int y) { return (x + y) % 2 == 0; }},
      {"one of four", [](int x, int y) { return x % 2 == 1 && y % 2 == 1; }},
      {"diagonals", [](int x, int y) { return (x + y) % 4 < 2; }},
      {"wide columns", [](int x, int) { return x % 4 < 2; }},
      {"every third column", [](int x, int) { return x % 3 == 0; }},
      {"half", [](int x, int) { return x < 16; }}};
  for (const auto& [name, has_noise] : patterns) EXPECT_NEAR(error_at_the_end(has_noise, 0.1), 0.1, 0.02) << name;
}

TEST(GroupStopping, AFrameThatEndsAtOnceNeedsNoRestoring) {
  GroupStopping stopping;
  Film film({0, 0, 8, 8}, 0);
  fill(16, 0, &film);
  stopping.update(film, film_noise(film), 0.1);
  EXPECT_TRUE(stopping.all_ended());
  EXPECT_FALSE(stopping.show_ended(&film));
}

}  // namespace
}  // namespace alabaster
