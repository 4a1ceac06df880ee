// Ends a frame at a target error. Each group of pixels ends as soon as the error of another group has reached the
// target, with the doubt about it: the root of the sum of the squares of the error and of the distance from it to the
// upper end of its interval. Where few samples find light, groups differ in what they have found, and one that has
// found little must not end another early. pixel_group.h says why another group decides.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>

#include "core/convergence/frame_error.h"

namespace alabaster {

class GroupStopping {
 public:
  /// Ends groups by the errors of `film`, whose noise is `noise`. A group that ends before others is traced on while
  /// they need its error, so its pixels are kept here as they are now.
  void update(const Film& film, const NoiseImage& noise, double target);
  /// The rule of update(). Returns the groups that end now, one bit each. `errors`: of each group's pixels, unknown for
  /// a group that has none.
  uint32_t decide(const std::array<FrameError, kPixelGroups>& errors, double target);

  // For checkpoints. The film is null where no group is kept, else of the same window, AOVs and extras as the film.
  uint32_t ended() const { return ended_; }
  uint32_t kept() const { return kept_; }
  const std::shared_ptr<Film>& kept_film() const { return kept_film_; }
  /// True after show_ended(): the film has the pixels that were kept, and kept_film() those that were traced on.
  bool shows_ended() const { return shows_ended_; }
  /// From a checkpoint whose film shows the pixels that were traced on.
  void restore(uint32_t ended, uint32_t kept, std::shared_ptr<Film> kept_film) {
    ended_ = ended, kept_ = kept, kept_film_ = std::move(kept_film), shows_ended_ = false;
  }

  /// Root mean square of the groups' errors, without their doubt, at the last decide(); 0: none.
  double error() const { return error_; }
  bool all_ended() const { return ended_ == kAllPixelGroups; }
  /// Groups that have not ended, and those whose errors end them.
  uint32_t groups_to_trace() const;
  /// Has `film`, that of update(), show the pixels of groups that ended before others as they were then. Those that
  /// were traced on since are kept in their place. False: there are none.
  bool show_ended(Film* film);

 private:
  double error_ = 0;
  uint32_t ended_ = 0, kept_ = 0;    // groups
  std::shared_ptr<Film> kept_film_;  // the pixels of `kept_`
  bool shows_ended_ = false;
};

/// Samples per pixel at which the error is checked again after `samples`: 16, 18, 20, 22, 24, 27, 30, ... They are
/// fixed beforehand, so that no pixel's own samples decide when it is checked.
inline uint32_t next_error_check(uint32_t samples) {
  return samples + std::max(2u, samples / 8);
}

}  // namespace alabaster
