// A process that was forked from one with delegates, and messages that name what is wrong with a frame.
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <functional>
#include <thread>
#include <utility>

#include "testenv/unit/delegate/c_api/door_fixture.h"

namespace alabaster::c_api_testing {
namespace {

/// The exit status of a child that runs `body`; -1 if it does not end within 30 seconds.
int status_of_child(const std::function<int()>& body) {
  const pid_t child = fork();
  if (child == 0) std::_Exit(body());
  for (int look = 0; look < 3000; ++look) {
    int status = 0;
    if (waitpid(child, &status, WNOHANG) == child) return WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + status;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  return -1;
}

/// The fixture of another test, made within this one.
class DoorOfAChild : public Door {
 public:
  bool draws() { return centre(render())[3] == 1; }

 private:
  void TestBody() override {}
};

class DoorFork : public Door {
 protected:
  DoorFork() {
    set_samples(1 << 20);
    EXPECT_EQ(start(), ALABASTER_OK);
    EXPECT_EQ(api().pass_wait(pass_, 0.2, nullptr), ALABASTER_OK);
  }
  ~DoorFork() override {  // the parent's render goes on
    int32_t state = 0;
    EXPECT_EQ(api().pass_state(pass_, &state), ALABASTER_OK);
    EXPECT_EQ(state, ALABASTER_RENDERING);
  }
};

TEST_F(DoorFork, AChildDestroysWhatItsParentMade) {
  EXPECT_EQ(status_of_child([&] {
              api().pass_destroy(pass_);
              api().buffer_destroy(color_);
              api().delegate_destroy(delegate_);
              api().scene_destroy(scene_);
              return 7;
            }),
            7);
  EXPECT_EQ(status_of_child([&] {
              api().scene_destroy(scene_);
              api().delegate_destroy(delegate_);
              api().buffer_destroy(color_);
              api().pass_destroy(pass_);
              return 7;
            }),
            7);
}

TEST_F(DoorFork, AChildUnmapsWhatItsParentMapped) {
  AlabasterPixels pixels = {};
  pixels.size = sizeof pixels;
  ASSERT_EQ(api().buffer_map(color_, &pixels), ALABASTER_OK);
  EXPECT_EQ(status_of_child([&] { return api().pixels_unmap(&pixels) == ALABASTER_OK ? 7 : 8; }), 7);
  EXPECT_EQ(api().pixels_unmap(&pixels), ALABASTER_OK);
}

// Nothing but the mapping keeps the buffer.
TEST_F(Door, AChildUnmapsABufferThatItsParentHasDestroyed) {
  render();
  AlabasterPixels pixels = {};
  pixels.size = sizeof pixels;
  ASSERT_EQ(api().buffer_map(color_, &pixels), ALABASTER_OK);
  api().pass_destroy(std::exchange(pass_, nullptr));
  api().buffer_destroy(std::exchange(color_, nullptr));
  EXPECT_EQ(status_of_child([&] { return api().pixels_unmap(&pixels) == ALABASTER_OK ? 7 : 8; }), 7);
  EXPECT_EQ(api().pixels_unmap(&pixels), ALABASTER_OK);
}

// promise: embedding.forks
TEST_F(DoorFork, AChildCannotUseWhatItsParentMade) {
  const std::function<AlabasterStatus()> calls[] = {
      [&] { return start(); },
      [&] { return api().pass_wait(pass_, 1, nullptr); },
      [&] {
        int32_t state = 0;
        return api().pass_state(pass_, &state);
      },
      [&] { return api().stop(delegate_); },
      [&] { return api().restart(delegate_); },
      [&] { return api().show(delegate_, nullptr); },
      [&] { return api().buffer_resize(color_, 4, 4, ALABASTER_FLOAT32_4); },
      [&] {
        AlabasterPixels pixels = {};
        pixels.size = sizeof pixels;
        return api().buffer_map(color_, &pixels);
      },
      [&] { return api().scene_clear(scene_); },
      [&] { return set(scene_, "/other", "mesh"); },
      [&] {
        return edit(scene_, "/quad", {{"visible", flag(0)}});
      },
      [&] { return api().scene_write(scene_, "/gone/scene.alab", nullptr, nullptr, 0); },
  };
  for (const auto& call : calls)
    EXPECT_EQ(status_of_child([&] {
                const bool refused = call() == ALABASTER_INVALID_ARGUMENT;
                return refused && std::string(api().last_error()).find("forked") != std::string::npos ? 7 : 8;
              }),
              7);
}

TEST_F(DoorFork, AChildMakesNoDelegateOfItsOwn) {
  EXPECT_EQ(status_of_child([&] {
              AlabasterDelegate* own = nullptr;
              const bool refused = api().delegate_create(nullptr, nullptr, &own) == ALABASTER_INPUT_FAILED;
              return refused && std::string(api().last_error()).find("before the fork") != std::string::npos ? 7 : 8;
            }),
            7);
}

// promise: embedding.forks
TEST(DoorForkWithoutDelegates, AChildMakesItsOwn) {
  {
    DoorOfAChild before;
    EXPECT_TRUE(before.draws());
  }
  EXPECT_EQ(status_of_child([&] {
              DoorOfAChild own;
              return own.draws() ? 7 : 8;
            }),
            7);
}

class DoorFrame : public Door {};

TEST_F(DoorFrame, ANegativeSizeIsRefused) {
  AlabasterFrame frame = {};
  frame.size = sizeof frame;
  frame.camera = "/camera", frame.width = -5, frame.height = 8;
  int32_t width = 0, height = 0;
  EXPECT_EQ(api().frame_size(delegate_, &frame, &width, &height), ALABASTER_INVALID_ARGUMENT);
  EXPECT_NE(std::string(api().last_error()).find("-5 x 8"), std::string::npos) << api().last_error();
  EXPECT_EQ(api().pass_start(pass_, &frame), ALABASTER_INVALID_ARGUMENT);
  for (const int32_t wrong : {-5, 0, (1 << 20) + 1}) {
    EXPECT_EQ(set(scene_, "/settings", "renderSettings", {{"height", whole(wrong)}}), ALABASTER_INVALID_ARGUMENT);
    EXPECT_TRUE(says("'height' must be a whole number from 1 to 1048576")) << api().last_error();
  }
}

TEST_F(DoorFrame, AnUnknownAovIsNamed) {
  int32_t format = ALABASTER_INT32;
  EXPECT_EQ(api().aov_format(delegate_, "colour", &format), ALABASTER_OK);
  EXPECT_EQ(format, ALABASTER_FORMAT_NONE);
  EXPECT_STREQ(api().last_error(), "there is no AOV 'colour'; did you mean 'color'?");
}

}  // namespace
}  // namespace alabaster::c_api_testing
