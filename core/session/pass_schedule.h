// Which samples each pass takes. Early passes are small, so that a picture is there soon; later ones are large, so that
// passes cost little.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/film/film.h"

namespace alabaster {

using PassSchedule = std::vector<SampleRange>;

/// Ranges that cover `all` in order: from 0 on 1, 1, 2, 4, 8, then 16 at a time.
inline PassSchedule make_pass_schedule(const SampleRange& all) {
  constexpr uint32_t kLargest = 16;
  PassSchedule schedule;
  for (uint32_t begin = all.begin; begin < all.end;) {
    const uint32_t count = std::min({std::max(1u, begin), kLargest, all.end - begin});
    schedule.push_back({begin, begin + count});
    begin += count;
  }
  return schedule;
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
