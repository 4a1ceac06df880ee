// Which samples each pass takes: pure, so that it can be tested. Early passes are small (a picture soon), later ones
// large (little overhead).
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace alabaster {

struct SampleRange {
  uint32_t begin = 0, end = 0;
};
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

}  // namespace alabaster
