#include "core/convergence/group_stopping.h"

#include <algorithm>
#include <cmath>

namespace alabaster {

void GroupStopping::update(const Film& film, const NoiseImage& noise, double target) {
  // An error that is not known yet ends nothing.
  if (noise.pixels.empty()) return;
  if (std::any_of(noise.pixels.begin(), noise.pixels.end(), [](const PixelNoise& p) { return p.samples < 2; })) return;
  std::array<FrameError, kPixelGroups> errors;
  for (int g = 0; g < kPixelGroups; ++g) errors[static_cast<size_t>(g)] = estimate_frame_error(noise, {}, 1u << g);
  const uint32_t ending = decide(errors, target);
  if (all_ended() || !ending) return;  // the last to end are not traced on
  if (!kept_film_) kept_film_ = std::make_shared<Film>(film.data_window(), film.aovs(), film.extras());
  copy_groups(film, ending, kept_film_.get());
  kept_ |= ending;
}

uint32_t GroupStopping::decide(const std::array<FrameError, kPixelGroups>& errors, double target) {
  uint32_t ending = 0;
  double squares = 0;
  for (int g = 0; g < kPixelGroups; ++g) {
    // A frame of a few pixels may lack the other group: there a group ends by its own error.
    const FrameError& other = errors[static_cast<size_t>(stopping_group(g))];
    const FrameError& error = other.known ? other : errors[static_cast<size_t>(g)];
    // An empty group has no error; one that is not finite goes on.
    if (error.with_doubt() <= target) ending |= 1u << g;
    squares += error.relative_rmse * error.relative_rmse;
  }
  error_ = std::sqrt(squares / kPixelGroups);
  ending &= ~ended_;
  ended_ |= ending;
  return ending;
}

uint32_t GroupStopping::groups_to_trace() const {
  uint32_t groups = 0;
  for (int g = 0; g < kPixelGroups; ++g)
    if (!(ended_ >> g & 1)) groups |= 1u << g | 1u << stopping_group(g);
  return groups;
}

bool GroupStopping::show_ended(Film* film) {
  if (!kept_film_) return false;
  if (!shows_ended_) exchange_groups(kept_, film, kept_film_.get());
  shows_ended_ = true;
  return true;
}

}  // namespace alabaster
