// A delegate that shows one scene after the other.
#include <atomic>
#include <thread>

#include "testenv/support/failing_memory.h"
#include "testenv/unit/delegate/c_api/door_fixture.h"

namespace alabaster::c_api_testing {
namespace {

class DoorShow : public Door {
 protected:
  DoorShow() { EXPECT_EQ(api().delegate_create(nullptr, nullptr, &other_), ALABASTER_OK); }
  ~DoorShow() override { api().delegate_destroy(other_); }

  AlabasterDelegate* other_ = nullptr;
};

TEST_F(DoorShow, ASceneIsDrawnByOneDelegate) {
  EXPECT_EQ(api().show(other_, scene_), ALABASTER_INVALID_ARGUMENT);
  EXPECT_STREQ(api().last_error(), "another delegate draws this scene: destroy it, or let it show another one");
  EXPECT_EQ(api().show(delegate_, nullptr), ALABASTER_OK);
  EXPECT_EQ(api().show(other_, scene_), ALABASTER_OK);
  EXPECT_EQ(api().show(delegate_, scene_), ALABASTER_INVALID_ARGUMENT);
  EXPECT_EQ(api().show(other_, nullptr), ALABASTER_OK);
  EXPECT_EQ(api().show(delegate_, scene_), ALABASTER_OK);
  EXPECT_EQ(centre(render())[3], 1);
}

// A call that fails says so, and the next one draws the whole scene.
TEST_F(DoorShow, MemoryThatRunsOutIsAnError) {
  for (size_t allowed = 0;; ++allowed) {
    ASSERT_LT(allowed, 5000u);
    ASSERT_EQ(api().show(delegate_, nullptr), ALABASTER_OK);
    AlabasterStatus status = ALABASTER_OK;
    bool failed = false;
    {
      const testing::FailingMemory memory(allowed, 1);
      status = api().show(delegate_, scene_);
      failed = memory.failed();
    }
    if (status != ALABASTER_OK) {
      EXPECT_EQ(status, ALABASTER_OUT_OF_MEMORY) << allowed;
      ASSERT_EQ(api().show(delegate_, scene_), ALABASTER_OK) << allowed << ": " << api().last_error();
    }
    ASSERT_EQ(centre(render())[3], 1) << allowed << (status == ALABASTER_OK ? ": said to be shown" : ": shown again");
    if (!failed) break;
  }
}

// A scene that could not be taken away stays, and the one in its place is free.
TEST_F(DoorShow, AFailureLeavesTheOtherSceneFree) {
  AlabasterScene* next = nullptr;
  ASSERT_EQ(api().scene_create(nullptr, nullptr, &next), ALABASTER_OK);
  for (size_t allowed = 0;; ++allowed) {
    ASSERT_LT(allowed, 5000u);
    bool failed = false;
    {
      const testing::FailingMemory memory(allowed, 1);
      static_cast<void>(api().show(delegate_, next));
      failed = memory.failed();
    }
    ASSERT_EQ(api().show(delegate_, nullptr), ALABASTER_OK) << allowed;
    for (AlabasterScene* scene : {scene_, next}) {
      ASSERT_EQ(api().show(other_, scene), ALABASTER_OK) << allowed << ": " << api().last_error();
      ASSERT_EQ(api().show(other_, nullptr), ALABASTER_OK);
    }
    ASSERT_EQ(api().show(delegate_, scene_), ALABASTER_OK) << allowed;
    if (!failed) break;
  }
  ASSERT_EQ(api().show(delegate_, nullptr), ALABASTER_OK);
  api().scene_destroy(next);
}

// It is never taken for a forked child.
TEST_F(DoorShow, AThreadThatEditsMeanwhileIsServed) {
  std::atomic<bool> over{false};
  std::atomic<int> refused{0};
  std::thread editor([&] {
    while (!over) refused += edit(scene_, "/quad", {{"visible", flag(1)}}) != ALABASTER_OK;
  });
  for (int i = 0; i < 300; ++i) {
    EXPECT_EQ(api().show(delegate_, nullptr), ALABASTER_OK);
    EXPECT_EQ(api().show(delegate_, scene_), ALABASTER_OK);
  }
  over = true;
  editor.join();
  EXPECT_EQ(refused, 0);
}

}  // namespace
}  // namespace alabaster::c_api_testing
