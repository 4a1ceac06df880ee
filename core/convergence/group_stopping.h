// When a frame that was asked for an error ends: each group of pixels as soon as another one's error is small enough
// (core/convergence/pixel_group.h says why). Pure, so that it can be tested.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "core/convergence/pixel_group.h"

namespace alabaster {

class GroupStopping {
 public:
  /// Groups that end now, one bit each. `errors`: of each group's pixels, unknown if it has none.
  uint32_t decide(const std::array<FrameError, kPixelGroups>& errors, double target) {
    uint32_t ending = 0;
    for (int g = 0; g < kPixelGroups; ++g) {
      // A frame one pixel wide has no such group; it must decide for itself.
      const FrameError& other = errors[static_cast<size_t>(stopping_group(g))];
      const FrameError& error = other.known ? other : errors[static_cast<size_t>(g)];
      if (!error.known || error.relative_rmse <= target) ending |= 1u << g;
    }
    ending &= ~ended_;
    ended_ |= ending;
    return ending;
  }
  uint32_t ended() const { return ended_; }
  bool all_ended() const { return ended_ == kAll; }
  /// Groups that are to be traced: those that go on, and those that they wait for.
  uint32_t traced() const {
    uint32_t groups = 0;
    for (int g = 0; g < kPixelGroups; ++g)
      if (!(ended_ >> g & 1)) groups |= 1u << g | 1u << stopping_group(g);
    return groups;
  }
  static constexpr uint32_t kAll = (1u << kPixelGroups) - 1;

 private:
  uint32_t ended_ = 0;
};

/// Looks come at numbers of samples that are fixed beforehand, for the same reason: 16, 18, 20, 22, 24, 27, 30, ...
inline uint32_t next_look(uint32_t samples) {
  return samples + std::max(2u, samples / 8);
}

}  // namespace alabaster
