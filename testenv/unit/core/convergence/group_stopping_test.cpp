#include "core/convergence/group_stopping.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <utility>

#include "core/sampling/pixel_sampler.h"
#include "testenv/support/relative_error.h"

namespace alabaster {
namespace {

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

}  // namespace
}  // namespace alabaster
