// Files that change beside a window.
#include "delegate/view/scene_reload.h"

#include <thread>

#include "delegate/cli/exit_codes.h"
#include "testenv/unit/delegate/description/scene_fixture.h"

namespace alabaster::view {
namespace {

namespace fs = std::filesystem;

class SceneReloadTest : public hd::description::SceneFiles {
 protected:
  void SetUp() override {
    SceneFiles::SetUp();
    const auto begun = SceneReload::Time::clock::now();
    shown.load(folder_ / "lit.gltf", {}, sink_);
    watch(begun);
  }
  void watch(SceneReload::Time begun) {
    reload = std::make_unique<SceneReload>(
        [this] {
          ++loads;
          auto session = std::make_unique<cli::SceneSession>();
          session->load(folder_ / "lit.gltf", {}, sink_);
          return session;
        },
        folder_ / "lit.gltf", shown, begun, sink_);
  }
  // Another time than any before, however coarse the clock of the disk.
  void touch(const std::string& name) {
    fs::last_write_time(folder_ / name, fs::file_time_type::clock::now() + std::chrono::hours(++touched_));
  }
  std::unique_ptr<cli::SceneSession> loaded() {
    while (reload->is_busy())
      if (auto session = reload->take()) return session;
    return nullptr;
  }

  cli::SceneSession shown;
  std::unique_ptr<SceneReload> reload;
  int loads = 0;

 private:
  const hd::DiagnosticSink sink_ = [this](const hd::Diagnostic& d) { diagnostics.push_back(d); };
  int touched_ = 0;
};

TEST_F(SceneReloadTest, AFileThatTheSceneNamesIsSeenToChange) {
  reload->look();
  EXPECT_FALSE(reload->has_changed());
  touch("patch.gltf");  // of another scene
  reload->look();
  EXPECT_FALSE(reload->has_changed());
  for (const char* name : {"lit.gltf", "patch.bin"}) {
    touch(name);
    reload->look();
    EXPECT_TRUE(reload->has_changed()) << name;
    reload->begin();
    EXPECT_NE(loaded(), nullptr);
    reload->look();
    EXPECT_FALSE(reload->has_changed()) << "that is what was loaded";
  }
  EXPECT_EQ(loads, 2) << "nothing is loaded without a word";
}

TEST_F(SceneReloadTest, AFileThatIsSavedWhileItsSceneLoadsIsOffered) {
  watch(fs::last_write_time(folder_ / "patch.bin") - std::chrono::seconds(1));
  reload->look();
  EXPECT_TRUE(reload->has_changed());
  reload->begin();
  ASSERT_NE(loaded(), nullptr);
  reload->look();
  EXPECT_FALSE(reload->has_changed());
}

TEST_F(SceneReloadTest, AFileThatIsWrittenAgainMayBeMissingForAMoment) {
  fs::rename(folder_ / "patch.bin", folder_ / "away.bin");
  reload->look();
  EXPECT_FALSE(reload->has_changed());
  fs::rename(folder_ / "away.bin", folder_ / "patch.bin");
  reload->look();
  EXPECT_FALSE(reload->has_changed()) << "it is the same";
}

TEST_F(SceneReloadTest, WhatCannotBeLoadedIsReportedAndTheNextChangeIsOffered) {
  write("lit.gltf", "{");
  touch("lit.gltf");
  reload->look();
  EXPECT_TRUE(reload->has_changed());
  reload->begin();
  EXPECT_EQ(loaded(), nullptr);
  ASSERT_GE(diagnostics.size(), 2u);
  EXPECT_EQ(diagnostics[0].severity, hd::Severity::error);
  EXPECT_EQ(diagnostics.back().code, "view.reload");
  reload->look();
  EXPECT_FALSE(reload->has_changed());
  write("lit.gltf", hd::description::patch_gltf(true, true));
  touch("lit.gltf");
  reload->look();
  EXPECT_TRUE(reload->has_changed());
}

TEST_F(SceneReloadTest, ByItselfItWaitsUntilTheFileRests) {
  reload->by_itself = true;
  for (const char* name : {"lit.gltf", "patch.bin"}) touch(name);
  reload->look();
  EXPECT_FALSE(reload->is_busy()) << "it may be half written";
  const auto begun = std::chrono::steady_clock::now();
  while (!reload->is_busy() && std::chrono::steady_clock::now() - begun < std::chrono::seconds(20)) {
    reload->look();
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_NE(loaded(), nullptr);
  EXPECT_EQ(loads, 1);
}

}  // namespace
}  // namespace alabaster::view
