// Which samples each pass takes. Early passes are small, so that a picture is there soon; later ones are large, so that
// passes cost little. The samples themselves do not depend on it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/film/film.h"

namespace alabaster {

/// A pass over all tiles.
struct SamplePass {
  uint32_t end = 0;  // afterwards each of its pixels has so many samples
  int block = 1;     // its pixels: the upper left corners of blocks of so many pixels on a side
};
using PassSchedule = std::vector<SamplePass>;

/// Passes that take each pixel from `all.begin` samples to `all.end`: from 0 on 1, 1, 2, 4, 8, then 16 at a time. The
/// first sample is taken in ever smaller blocks, so that something covers the frame at once.
inline PassSchedule make_pass_schedule(const SampleRange& all) {
  constexpr uint32_t kMostSamples = 16;
  constexpr int kLargestBlock = 16;
  PassSchedule schedule;
  if (all.begin == 0 && all.end > 0)
    for (int block = kLargestBlock; block > 1; block /= 2) schedule.push_back({1, block});
  for (uint32_t end = all.begin; end < all.end;) {
    end += std::min({std::max(1u, end), kMostSamples, all.end - end});
    schedule.push_back({end});
  }
  return schedule;
}

/// The passes over all pixels among the first `count`.
inline uint32_t count_whole_passes(const PassSchedule& schedule, uint32_t count) {
  return static_cast<uint32_t>(std::count_if(schedule.begin(), schedule.begin() + count,
                                             [](const SamplePass& pass) { return pass.block == 1; }));
}

/// Counts the passes that all tiles have finished. Passes of different tiles overlap; those of one tile end in order.
class FinishedPasses {
 public:
  FinishedPasses(size_t tiles, size_t passes) : tiles_left_(passes, tiles) {}
  void add_tile(size_t pass) {
    --tiles_left_[pass];
    while (count_ < tiles_left_.size() && tiles_left_[count_] == 0) ++count_;
  }
  uint32_t count() const { return static_cast<uint32_t>(count_); }

 private:
  std::vector<size_t> tiles_left_;  // of each pass
  size_t count_ = 0;
};

}  // namespace alabaster
