// Callbacks that call the library: allowed or refused, as the header says.
#include <unistd.h>

#include <filesystem>
#include <functional>

#include "testenv/unit/delegate/c_api/door_fixture.h"

namespace alabaster::door_testing {
namespace {

class DoorCallbacks : public Door {
 protected:
  DoorCallbacks() {
    const AlabasterRenderSettings settings = {sizeof settings, "/camera", kSide, kSide, 0, {}, 0, nullptr, 0};
    EXPECT_EQ(api().set_render_settings(scene_, "/settings", &settings), ALABASTER_OK);
  }
  ~DoorCallbacks() override { std::filesystem::remove(file_); }

  /// Records, and calls `once` in the first call of the progress callback.
  AlabasterStatus record(std::function<void()> once) {
    once_ = std::move(once);
    const char* const files[] = {file_.c_str()};
    AlabasterRecordOptions options = {};
    options.size = sizeof options;
    options.files = files, options.file_count = 1;
    options.user = this;
    options.progress = [](void* user, const AlabasterProgress*) -> int32_t {
      if (const auto call = std::exchange(static_cast<DoorCallbacks*>(user)->once_, nullptr)) call();
      return 1;
    };
    const AlabasterStatus status = api().record(delegate_, &options, nullptr, nullptr);
    EXPECT_FALSE(once_) << "was called";
    return status;
  }

  std::function<void()> once_;
  const std::string file_ =
      (std::filesystem::temp_directory_path() / ("door_callbacks_" + std::to_string(getpid()) + ".exr")).string();
};

TEST_F(DoorCallbacks, ARecordInARecordIsRefused) {
  AlabasterStatus inner = ALABASTER_OK, shown = ALABASTER_OK, started = ALABASTER_OK;
  std::string why;
  EXPECT_EQ(record([&] {
              inner = api().record(delegate_, nullptr, nullptr, nullptr);
              why = api().last_error();
              shown = api().show(delegate_, nullptr);
              started = start();
            }),
            ALABASTER_OK)
      << api().last_error();
  EXPECT_EQ(inner, ALABASTER_INVALID_ARGUMENT);
  EXPECT_NE(why.find("record is called by the progress callback"), std::string::npos) << why;
  EXPECT_EQ(shown, ALABASTER_INVALID_ARGUMENT);
  EXPECT_EQ(started, ALABASTER_INVALID_ARGUMENT);
  EXPECT_TRUE(std::filesystem::exists(file_));
  EXPECT_EQ(record([] {}), ALABASTER_OK) << "the next one is none within another";
}

TEST_F(DoorCallbacks, EverythingElseMayBeCalledInARecord) {
  EXPECT_EQ(record([&] {
              EXPECT_EQ(set_quad({}), ALABASTER_OK) << api().last_error();
              AlabasterBuffer* other = nullptr;
              EXPECT_EQ(api().buffer_create(delegate_, 4, 4, ALABASTER_FLOAT32_4, &other), ALABASTER_OK);
              api().buffer_destroy(other);
              AlabasterPass* pass = nullptr;
              EXPECT_EQ(api().pass_create(delegate_, &pass), ALABASTER_OK);
              api().pass_destroy(pass);
              // At the path of the recording's buffer, as it was once.
              const AlabasterLight light = {sizeof light, "sphereLight", nullptr, nullptr, 0, 0};
              EXPECT_EQ(api().set_light(scene_, "/settings/buffer_color", &light), ALABASTER_OK);
            }),
            ALABASTER_OK)
      << api().last_error();
  // Without its camera the frame fails, but nothing else does.
  const AlabasterStatus cleared = record([&] {
    set_samples(100000);
    EXPECT_EQ(api().scene_clear(scene_), ALABASTER_OK);
    EXPECT_EQ(api().stop(delegate_), ALABASTER_OK);
  });
  EXPECT_NE(cleared, ALABASTER_OK);
}

TEST_F(DoorCallbacks, HandlesMayBeDestroyedInARecord) {
  const AlabasterStatus status = record([&] {
    api().pass_destroy(std::exchange(pass_, nullptr));
    api().buffer_destroy(std::exchange(color_, nullptr));
    api().scene_destroy(std::exchange(scene_, nullptr));
    api().delegate_destroy(std::exchange(delegate_, nullptr));
  });
  EXPECT_EQ(status, ALABASTER_OK) << api().last_error();
  EXPECT_TRUE(std::filesystem::exists(file_));
}

TEST_F(DoorCallbacks, VisitsMayCallTheLibrary) {
  const auto visit = [](void* user, const char* path, const AlabasterValue*) {
    auto* const scene = static_cast<AlabasterScene*>(user);
    EXPECT_EQ(api().remove(scene, path), ALABASTER_OK);
  };
  EXPECT_EQ(api().get_prims(scene_, visit, scene_), ALABASTER_OK);
  int left = 0;
  const auto count = [](void* user, const char*, const AlabasterValue*) { ++*static_cast<int*>(user); };
  EXPECT_EQ(api().get_prims(scene_, count, &left), ALABASTER_OK);
  EXPECT_EQ(left, 0);
  // The last of a handle.
  const auto destroy = [](void* user, const char*, const AlabasterValue*) {
    api().scene_destroy(std::exchange(*static_cast<AlabasterScene**>(user), nullptr));
  };
  ASSERT_EQ(set_quad({}), ALABASTER_OK);
  EXPECT_EQ(api().get_prims(scene_, destroy, &scene_), ALABASTER_OK);
}

/// Calls of a report callback.
struct Reporter {
  AlabasterScene* scene = nullptr;
  AlabasterScene* spare = nullptr;
  AlabasterStatus status = ALABASTER_OK;
};

TEST_F(DoorCallbacks, ReportsMustNotCallTheLibrary) {
  Reporter reporter;
  const auto report = [](void* user, const AlabasterDiagnostic*) {
    auto& it = *static_cast<Reporter*>(user);
    it.status = api().scene_clear(it.scene);
    api().scene_destroy(std::exchange(it.spare, nullptr));
  };
  ASSERT_EQ(api().scene_create(report, &reporter, &reporter.scene), ALABASTER_OK);
  ASSERT_EQ(api().scene_create(nullptr, nullptr, &reporter.spare), ALABASTER_OK);
  EXPECT_EQ(api().scene_load(reporter.scene, "/nowhere/a.gltf", nullptr, nullptr), ALABASTER_INPUT_FAILED);
  EXPECT_EQ(reporter.status, ALABASTER_INVALID_ARGUMENT);
  EXPECT_EQ(api().scene_clear(reporter.scene), ALABASTER_OK);
  api().scene_destroy(reporter.scene);
}

// The host's last reference to a delegate may go with an array that it had lent.
TEST_F(DoorCallbacks, ReleasesMayDestroyHandles) {
  struct Owner {
    Door* door = nullptr;
    std::function<void()> give;
    AlabasterStatus status = ALABASTER_OK;
  };
  Owner owner;
  owner.give = [&] {
    owner.status = api().scene_clear(scene_);
    api().pass_destroy(std::exchange(pass_, nullptr));
    api().buffer_destroy(std::exchange(color_, nullptr));
    api().delegate_destroy(std::exchange(delegate_, nullptr));
  };
  static constexpr float kCorners[] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
  const AlabasterValue lent = {
      ALABASTER_FLOAT3, 1, kCorners, 4, [](void* given) { static_cast<Owner*>(given)->give(); }, &owner};
  ASSERT_EQ(set_quad(lent), ALABASTER_OK);
  render();
  ASSERT_EQ(api().remove(scene_, "/quad"), ALABASTER_OK);
  render();  // the array is given back, by this thread or the builder
  for (int i = 0; i < 1000 && delegate_; ++i) usleep(1000);
  EXPECT_EQ(delegate_, nullptr);
  EXPECT_EQ(owner.status, ALABASTER_INVALID_ARGUMENT);
  EXPECT_EQ(api().scene_clear(scene_), ALABASTER_OK) << "what was put off is destroyed here";
}

}  // namespace
}  // namespace alabaster::door_testing
