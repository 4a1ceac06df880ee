#include "core/convergence/frame_error.h"

#include <gtest/gtest.h>

namespace alabaster {
namespace {

TEST(FrameError, SamplesForAnErrorFallWithItsSquare) {
  EXPECT_EQ(samples_for_error(1000, 4096, 0.011, 0.01), 1210u);
  EXPECT_EQ(samples_for_error(1000, 1100, 0.02, 0.01), 1100u) << "never more than allowed";
}

}  // namespace
}  // namespace alabaster
