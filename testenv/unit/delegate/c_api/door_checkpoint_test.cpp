// Renders that a host interrupts and continues by the commands of checkpoints.
#include <unistd.h>

#include <filesystem>

#include "testenv/support/checkpoint_file.h"
#include "testenv/unit/delegate/c_api/door_fixture.h"

namespace alabaster::door_testing {
namespace {

class DoorCheckpoints : public Door {
 protected:
  DoorCheckpoints() {
    // Noise: a small light before the quad.
    const float radius = 0.02f, intensity = 300.0f;
    const AlabasterParameter bulb[] = {{"radius", number(radius)}, {"intensity", number(intensity)}};
    const double before[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0.3, 0.2, 0.4, 1};
    const AlabasterLight light = {sizeof light, "sphereLight", before, bulb, 2, 0};
    EXPECT_EQ(api().set_light(scene_, "/bulb", &light), ALABASTER_OK);
    decide();
  }
  ~DoorCheckpoints() override { std::filesystem::remove(file_); }

  // Adaptive, to a target error that some pixels reach before others.
  void decide() {
    set_samples(1 << 14);
    const float error = 0.004f;
    const AlabasterValue target = number(error), one = whole(1), adaptive = {ALABASTER_BOOL, 0, &kTrue, 1, {}, {}};
    EXPECT_EQ(api().set_setting(delegate_, "targetError", &target), ALABASTER_OK) << api().last_error();
    EXPECT_EQ(api().set_setting(delegate_, "adaptive", &adaptive), ALABASTER_OK) << api().last_error();
    EXPECT_EQ(api().set_setting(delegate_, "threads", &one), ALABASTER_OK) << api().last_error();
  }
  void begin_anew() {
    api().pass_destroy(pass_);
    api().buffer_destroy(color_);
    api().delegate_destroy(delegate_);
    const AlabasterDelegateOptions options = {sizeof options, &Door::hear, this, nullptr, 0};
    EXPECT_EQ(api().delegate_create(&options, scene_, &delegate_), ALABASTER_OK) << api().last_error();
    EXPECT_EQ(api().buffer_create(delegate_, kSide, kSide, ALABASTER_FLOAT32_4, &color_), ALABASTER_OK);
    EXPECT_EQ(api().pass_create(delegate_, &pass_), ALABASTER_OK);
    decide();
  }
  std::string command(const char* name) {
    const std::string file = file_.string();
    const AlabasterParameter argument = {"file", {ALABASTER_STRING, 0, file.c_str(), 1, nullptr, nullptr}};
    std::string answer = "none";
    const AlabasterVisit keep = [](void* user, const char*, const AlabasterValue* value) {
      if (value->type == ALABASTER_STRING) *static_cast<std::string*>(user) = static_cast<const char*>(value->data);
    };
    EXPECT_EQ(api().command(delegate_, name, &argument, 1, keep, &answer), ALABASTER_OK) << api().last_error();
    return answer;
  }

  static constexpr uint8_t kTrue = 1;
  const std::filesystem::path file_ =
      std::filesystem::temp_directory_path() / ("alabaster_door_" + std::to_string(getpid()) + ".checkpoint");
};

TEST_F(DoorCheckpoints, AnAdaptiveRenderGoesOnAfterAGroupOfPixelsHasEnded) {
  const std::vector<float> whole = render();
  int32_t over = 1;
  uint32_t ended = 0;
  for (int attempt = 0; attempt < 20 && (over || !ended); ++attempt) {
    begin_anew();
    ASSERT_EQ(start(), ALABASTER_OK);
    for (over = 0, ended = 0; !over && !ended; ended = testing::ended_groups(file_)) {
      ASSERT_EQ(api().pass_wait(pass_, 0.001, &over), ALABASTER_OK);
      std::filesystem::remove(file_);
      if (!over) command("writeCheckpoint");
    }
  }
  ASSERT_NE(ended, 0u) << "all pixels end at once";
  begin_anew();
  EXPECT_EQ(command("resumeCheckpoint"), "");
  EXPECT_EQ(render(), whole);
}

}  // namespace
}  // namespace alabaster::door_testing
