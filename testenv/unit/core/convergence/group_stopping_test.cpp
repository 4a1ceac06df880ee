#include "core/convergence/group_stopping.h"

#include <gtest/gtest.h>

namespace alabaster {
namespace {

FrameError error_of(double relative_rmse) {
  FrameError error;
  error.known = true;
  error.relative_rmse = relative_rmse;
  return error;
}

// Diagonal pairs end each other; one that has ended is traced on while the other needs it.
TEST(GroupStopping, AnotherGroupsErrorEndsAGroup) {
  GroupStopping stopping;
  EXPECT_EQ(stopping.decide({error_of(3), error_of(3), error_of(3), error_of(3)}, 1), 0u);
  EXPECT_EQ(stopping.decide({error_of(1), error_of(3), error_of(3), error_of(3)}, 1), 0b0100u);
  EXPECT_EQ(stopping.traced(), GroupStopping::kAll);
  EXPECT_EQ(stopping.decide({error_of(1), error_of(3), error_of(1), error_of(3)}, 1), 0b0001u);
  EXPECT_EQ(stopping.traced(), 0b1010u);
  EXPECT_EQ(stopping.decide({error_of(3), error_of(1), error_of(3), error_of(1)}, 1), 0b1010u);
  EXPECT_TRUE(stopping.all_ended());
  EXPECT_EQ(stopping.traced(), 0u);
}

TEST(GroupStopping, WithoutTheOtherGroupAFrameDecidesForItself) {
  GroupStopping stopping;
  EXPECT_EQ(stopping.decide({error_of(3), FrameError{}, FrameError{}, error_of(1)}, 1), 0b1010u);
}

TEST(GroupStopping, LooksDoNotDependOnWhatIsSeen) {
  uint32_t look = 16;
  for (const uint32_t next : {18u, 20u, 22u, 24u, 27u, 30u, 33u}) EXPECT_EQ(look = next_look(look), next);
}

}  // namespace
}  // namespace alabaster
