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

// Two tiles: the first runs ahead.
TEST(FinishedPasses, CountWhatEveryTileHasFinished) {
  FinishedPasses finished(2, 3);
  finished.add_tile(0);
  finished.add_tile(1);
  EXPECT_EQ(finished.count(), 0u);
  finished.add_tile(2);
  finished.add_tile(0);
  EXPECT_EQ(finished.count(), 1u);
  finished.add_tile(1);
  EXPECT_EQ(finished.count(), 2u);
  finished.add_tile(2);
  EXPECT_EQ(finished.count(), 3u);
}

}  // namespace
}  // namespace alabaster
