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

/// Ranges that cover [0, samples) in order: 1, 1, 2, 4, 8, then 16 at a time.
inline PassSchedule make_pass_schedule(uint32_t samples) {
  constexpr uint32_t kLargest = 16;
  PassSchedule schedule;
  for (uint32_t begin = 0; begin < samples;) {
    const uint32_t count = std::min({std::max(1u, begin), kLargest, samples - begin});
    schedule.push_back({begin, begin + count});
    begin += count;
  }
  return schedule;
}

}  // namespace alabaster
