// Callbacks that call the library: allowed or refused, as the header says.
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <functional>
#include <future>
#include <map>
#include <thread>

#include "testenv/unit/delegate/c_api/door_fixture.h"

namespace alabaster::c_api_testing {
namespace {

class DoorCallbacks : public Door {
 protected:
  DoorCallbacks() { EXPECT_EQ(set_settings(), ALABASTER_OK); }
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
              EXPECT_EQ(set(scene_, "/settings/buffer_color", "sphereLight"), ALABASTER_OK);
            }),
            ALABASTER_OK)
      << api().last_error();
  // Without its prims the frame may end as it likes, but the library goes on.
  record([&] {
    EXPECT_EQ(api().scene_clear(scene_), ALABASTER_OK);
    EXPECT_EQ(api().stop(delegate_), ALABASTER_OK);
  });
  EXPECT_EQ(api().restart(delegate_), ALABASTER_OK);
  EXPECT_EQ(set_quad({}), ALABASTER_OK);
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

/// Calls of another thread while a visit lasts.
struct Visited {
  std::function<AlabasterStatus()> call;
  int visits = 0;
  bool returned = true;

  void visit() {
    if (visits++ > 0) return;
    answer = std::async(std::launch::async, call);
    returned = answer.wait_for(std::chrono::seconds(10)) == std::future_status::ready;
  }
  std::future<AlabasterStatus> answer;
};

TEST_F(DoorCallbacks, VisitsHoldNoLock) {
  const auto visit = [](void* user, const char*, const AlabasterValue*) { static_cast<Visited*>(user)->visit(); };
  const auto visit_setting = [](void* user, const AlabasterSetting*) { static_cast<Visited*>(user)->visit(); };
  const auto visit_pick = [](void* user, const AlabasterPick*) { static_cast<Visited*>(user)->visit(); };
  AlabasterBuffer* ids = nullptr;
  ASSERT_EQ(api().buffer_create(delegate_, kSide, kSide, ALABASTER_INT32, &ids), ALABASTER_OK);
  const AlabasterBinding bindings[] = {{"color", color_}, {"primId", ids}};
  AlabasterFrame frame = {};
  frame.size = sizeof frame;
  frame.camera = "/camera", frame.width = frame.height = kSide;
  frame.bindings = bindings, frame.binding_count = 2;
  ASSERT_EQ(api().pass_start(pass_, &frame), ALABASTER_OK);
  ASSERT_EQ(api().pass_wait(pass_, -1, nullptr), ALABASTER_OK);
  const AlabasterRect middle = {kSide / 2, kSide / 2, kSide / 2 + 1, kSide / 2 + 1};
  const char* const files[] = {file_.c_str()};
  AlabasterRecordOptions recorded = {};
  recorded.size = sizeof recorded;
  recorded.files = files, recorded.file_count = 1;
  const std::map<std::string, std::function<AlabasterStatus(Visited*)>> calls = {
      {"get_setting", [&](Visited* to) { return api().get_setting(delegate_, "samples", visit, to); }},
      {"get_settings", [&](Visited* to) { return api().get_settings(delegate_, visit_setting, to); }},
      {"command", [&](Visited* to) { return api().command(delegate_, "dumpScene", nullptr, 0, visit, to); }},
      {"stats", [&](Visited* to) { return api().stats(delegate_, visit, to); }},
      {"get_prims", [&](Visited* to) { return api().get_prims(scene_, visit, to); }},
      {"pick", [&](Visited* to) { return api().pick(pass_, &middle, visit_pick, to); }},
      {"record", [&](Visited* to) { return api().record(delegate_, &recorded, visit, to); }}};
  for (const auto& [name, call] : calls) {
    Visited visited;
    visited.call = [&] { return edit(scene_, "/quad", {{"visible", flag(1)}}); };
    EXPECT_EQ(call(&visited), ALABASTER_OK) << name << ": " << api().last_error();
    EXPECT_GT(visited.visits, 0) << name;
    EXPECT_TRUE(visited.returned) << name;
    EXPECT_TRUE(visited.visits > 0 && visited.answer.get() == ALABASTER_OK) << name;
  }
  api().buffer_destroy(ids);
}

// No other call may come.
TEST_F(DoorCallbacks, HandleDestroyedInAReportIsFreedByTheNextDestroy) {
  AlabasterScene *spare = nullptr, *other = nullptr, *reports = nullptr;
  const auto report = [](void* user, const AlabasterDiagnostic*) {
    api().scene_destroy(std::exchange(*static_cast<AlabasterScene**>(user), nullptr));
  };
  ASSERT_EQ(api().scene_create(report, &spare, &reports), ALABASTER_OK);
  ASSERT_EQ(api().scene_create(nullptr, nullptr, &spare), ALABASTER_OK);
  ASSERT_EQ(api().scene_create(nullptr, nullptr, &other), ALABASTER_OK);
  static constexpr float kPoints[] = {1, 1, 1, 0, 0, 0};
  int released = 0;
  const AlabasterValue lent = {ALABASTER_FLOAT3, ALABASTER_ARRAY, kPoints, 2, count_release, &released};
  ASSERT_EQ(set(spare, "/a", "mesh", {{"primvars:points", lent}}), ALABASTER_OK) << api().last_error();
  EXPECT_EQ(api().scene_load(reports, "/nowhere/a.gltf", nullptr, nullptr), ALABASTER_INPUT_FAILED);
  EXPECT_EQ(spare, nullptr);
  EXPECT_EQ(released, 0);
  api().scene_destroy(other);
  EXPECT_EQ(released, 1);
  api().scene_destroy(reports);
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
    AlabasterScene* scene = nullptr;
    AlabasterDelegate* spare = nullptr;
    AlabasterStatus status = ALABASTER_OK;
    std::atomic<bool> is_back{false};
  };
  Owner owner;
  owner.scene = scene_;
  ASSERT_EQ(api().delegate_create(nullptr, nullptr, &owner.spare), ALABASTER_OK);
  const auto give_back = [](void* given) {
    auto& it = *static_cast<Owner*>(given);
    it.status = api().scene_clear(it.scene);
    api().delegate_destroy(it.spare);
    it.is_back = true;
  };
  static constexpr float kCorners[] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
  ASSERT_EQ(set_quad({ALABASTER_FLOAT3, 1, kCorners, 4, give_back, &owner}), ALABASTER_OK);
  render();
  ASSERT_EQ(api().remove(scene_, "/quad"), ALABASTER_OK);
  render();  // the array is given back, by this thread or the builder
  for (int i = 0; i < 10000 && !owner.is_back; ++i) usleep(1000);
  ASSERT_TRUE(owner.is_back);
  EXPECT_EQ(owner.status, ALABASTER_INVALID_ARGUMENT);
  EXPECT_EQ(api().scene_clear(scene_), ALABASTER_OK) << "the delegate that was put off is destroyed here";
}

}  // namespace
}  // namespace alabaster::c_api_testing
