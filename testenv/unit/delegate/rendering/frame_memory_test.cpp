// The memory that is counted for a frame against what operator new gives out.
#include "core/session/frame_memory.h"

#include <gtest/gtest.h>

#include "testenv/support/failing_memory.h"
#include "testenv/support/frame_memory_cases.h"

namespace alabaster {
namespace {

// All that operator new gives to the session, at the same time.
TEST(FrameMemory, EstimateIsTheMostThatARenderHolds) {
  for (const testing::FrameMemoryCase& c : testing::frame_memory_cases()) {
    const RenderRequest request = testing::frame_memory_request(c.settings);
    testing::render(request);  // what stays, such as threads and tables, is there now
    size_t most = 0;
    {
      const testing::PeakMemory peak;
      testing::render(request);
      most = peak.bytes();
    }
    const size_t counted = frame_bytes(request.data_window, testing::kFrameMemoryAovs, c.settings);
    const size_t uncounted = size_t(1) << 20;  // tiles, threads
    EXPECT_LT(most, counted + uncounted) << c.name;
    // The second film is taken only where a group of pixels ends before others.
    const bool is_whole = c.settings.target_error == 0;
    EXPECT_TRUE(!is_whole || most + counted / 4 > counted) << c.name << ": counted in vain";
  }
}

}  // namespace
}  // namespace alabaster
