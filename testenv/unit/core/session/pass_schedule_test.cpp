#include "core/session/pass_schedule.h"

#include <gtest/gtest.h>

namespace alabaster {
namespace {

TEST(PassSchedule, CoversAllSamplesInOrder) {
  for (const uint32_t samples : {0u, 1u, 2u, 3u, 17u, 64u, 100u}) {
    uint32_t next = 0;
    for (const auto& range : make_pass_schedule({0, samples})) {
      EXPECT_EQ(range.begin, next);
      EXPECT_GT(range.end, range.begin);
      next = range.end;
    }
    EXPECT_EQ(next, samples);
  }
}

}  // namespace
}  // namespace alabaster
