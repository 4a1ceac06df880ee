#include "core/session/pass_schedule.h"

#include <gtest/gtest.h>

namespace alabaster {
namespace {

TEST(PassSchedule, CoversAllSamplesInOrder) {
  for (const uint32_t begin : {0u, 3u, 16u})
    for (const uint32_t samples : {0u, 1u, 2u, 3u, 17u, 64u, 100u}) {
      uint32_t end = begin;
      for (const SamplePass& pass : make_pass_schedule({begin, samples})) {
        if (pass.block > 1) continue;
        EXPECT_GT(pass.end, end);
        end = pass.end;
      }
      EXPECT_EQ(end, std::max(begin, samples));
    }
}

// promise: embedding.first_sample
TEST(PassSchedule, TheFirstSampleCoversTheFrameInEverSmallerBlocks) {
  const PassSchedule schedule = make_pass_schedule({0, 64});
  for (size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(schedule[i].end, 1u);
    EXPECT_EQ(schedule[i].block, 16 >> i);
  }
  EXPECT_EQ(count_whole_passes(schedule, 4), 0u);
  EXPECT_EQ(count_whole_passes(schedule, 6), 2u);
  EXPECT_EQ(make_pass_schedule({1, 64}).front().block, 1) << "the frame is covered";
}

// Two tiles: the first runs ahead.
TEST(FinishedPasses, CountPassesThatEveryTileHasFinished) {
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
