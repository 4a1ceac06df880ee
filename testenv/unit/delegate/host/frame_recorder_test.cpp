#include "delegate/host/frame_recorder.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <thread>

#include "testenv/support/stage.h"

namespace alabaster::hd::host {
namespace {

struct Folder {
  std::string path;
  Folder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "alabaster_record_XXXXXX").string();
    path = mkdtemp(pattern.data());
  }
  ~Folder() { std::filesystem::remove_all(path); }
};

RenderSettingsDescription settings_for(const std::string& file, int samples) {
  RenderSettingsDescription settings;
  settings.camera = "/camera";
  settings.width = 24;
  settings.height = 16;
  settings.settings = {{"samples", samples}};
  settings.products.resize(1);
  settings.products[0].file = file;
  return settings;
}

TEST(FrameRecorder, RendersAndWritesItsProducts) {
  const Folder folder;
  Stage stage;
  stage.add_basic_scene();
  stage.scene.SetRenderSettings("/settings", settings_for(folder.path + "/frame.exr", 2));
  int told = 0;
  RecordOptions options;
  options.progress = [&](const RecordProgress& p) {
    ++told;
    EXPECT_EQ(p.samples_total, 2u);
  };
  const RecordResult result = RecordFrame(stage.index.get(), &stage.scene, "/settings", options);
  EXPECT_EQ(result.status, RecordStatus::done);
  ASSERT_EQ(result.written.size(), 1u);
  EXPECT_TRUE(std::filesystem::exists(result.written[0]));
  EXPECT_GE(told, 1);
  for (const char* key : {"phase.sync.wall", "phase.sync.cpu", "phase.render.wall", "phase.write.wall"})
    EXPECT_TRUE(result.stats.count(key)) << key;
  EXPECT_EQ(result.stats.at("samplesTotal").number_or(0), 2);
  EXPECT_FALSE(stage.index->Has("/settings/buffer_color")) << "its buffers are gone";
  EXPECT_TRUE(stage.delegate->GetRenderSetting("renderSettingsPrimPath").empty());
}

TEST(FrameRecorder, RefusesBeforeRenderingWhatCannotSucceed) {
  const Folder folder;
  Stage stage;
  stage.add_basic_scene();
  const auto record = [&](const Path& settings) {
    return RecordFrame(stage.index.get(), &stage.scene, settings, {}).status;
  };
  EXPECT_EQ(record("/nowhere"), RecordStatus::input_failed);
  RenderSettingsDescription settings = settings_for(folder.path + "/frame.exr", 1);
  settings.width = 0;
  stage.scene.SetRenderSettings("/size", settings);
  EXPECT_EQ(record("/size"), RecordStatus::input_failed);
  stage.scene.SetRenderSettings("/file", settings_for(folder.path + "/no/such/folder/frame.exr", 1));
  EXPECT_EQ(record("/file"), RecordStatus::output_failed);
  settings = settings_for(folder.path + "/frame.exr", 1);
  settings.crop = Rect2i{24, 0, 30, 16};
  stage.scene.SetRenderSettings("/crop", settings);
  EXPECT_EQ(record("/crop"), RecordStatus::input_failed) << "the frame ends at 24";
  settings = settings_for(folder.path + "/frame.exr", 1);
  settings.camera = "/nowhere";
  stage.scene.SetRenderSettings("/camera_missing", settings);
  EXPECT_EQ(record("/camera_missing"), RecordStatus::input_failed);
  settings = settings_for(folder.path + "/frame.exr", 1);
  settings.crop = Rect2i{-2000000000, 0, 2000000000, 4};
  stage.scene.SetRenderSettings("/crop", settings);
  EXPECT_EQ(record("/crop"), RecordStatus::input_failed);
  settings = settings_for(folder.path + "/frame.exr", 1);
  settings.width = settings.height = 65536;  // more than a buffer may hold
  stage.scene.SetRenderSettings("/huge", settings);
  EXPECT_EQ(record("/huge"), RecordStatus::input_failed);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path));
}

TEST(FrameRecorder, ThrowsNothingThatItsHostThrowsAndTidiesUp) {
  const Folder folder;
  Stage stage;
  stage.add_basic_scene();
  stage.scene.SetRenderSettings("/settings", settings_for(folder.path + "/frame.exr", 2));
  stage.delegate->SetRenderSetting("renderSettingsPrimPath", "/before");
  std::vector<std::string> codes;
  RecordOptions options;
  options.progress = [](const RecordProgress&) { throw std::runtime_error("no terminal"); };
  options.diagnostics = [&](const Diagnostic& d) {
    codes.push_back(d.code);
    throw 7;
  };
  RecordResult result;
  EXPECT_NO_THROW(result = RecordFrame(stage.index.get(), &stage.scene, "/settings", options));
  EXPECT_EQ(result.status, RecordStatus::render_failed);
  EXPECT_EQ(codes, std::vector<std::string>{"record.exception"});
  EXPECT_FALSE(stage.index->Has("/settings/buffer_color")) << "its buffers are gone";
  EXPECT_EQ(stage.delegate->GetRenderSetting("renderSettingsPrimPath").text_or(""), "/before");
  EXPECT_TRUE(std::filesystem::is_empty(folder.path));
  EXPECT_EQ(RecordFrame(stage.index.get(), &stage.scene, "/settings", {}).status, RecordStatus::done) << "as if new";
}

/// The basic scene, and settings for a frame of so many samples in a folder of its own.
struct StagedFrame {
  const Folder folder;
  Stage stage;

  explicit StagedFrame(int samples) {
    stage.add_basic_scene();
    stage.scene.SetRenderSettings("/settings", settings_for(folder.path + "/frame.exr", samples));
  }
};

TEST(FrameRecorder, CancelEndsSoonAndWritesWhatThereIs) {
  StagedFrame frame(1 << 20);
  Stage& stage = frame.stage;
  std::atomic<bool> cancel{false};
  RecordOptions options;
  options.cancel = &cancel;
  std::chrono::steady_clock::time_point asked;
  std::thread user([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(150));
    asked = std::chrono::steady_clock::now();
    cancel = true;
  });
  const RecordResult result = RecordFrame(stage.index.get(), &stage.scene, "/settings", options);
  const auto over = std::chrono::steady_clock::now();
  user.join();
  EXPECT_EQ(result.status, RecordStatus::interrupted);
  EXPECT_EQ(result.written.size(), 1u);
  EXPECT_LT(std::chrono::duration<double>(over - asked).count(), 2.0) << "generous: the machine may be busy";
  EXPECT_FALSE(stage.delegate->IsStopped());
}

TEST(FrameRecorder, CancelBeforeItBeginsWritesNothing) {
  StagedFrame frame(4);
  Stage& stage = frame.stage;
  const std::atomic<bool> cancel{true};
  RecordOptions options;
  options.cancel = &cancel;
  EXPECT_EQ(RecordFrame(stage.index.get(), &stage.scene, "/settings", options).status, RecordStatus::interrupted);
  EXPECT_TRUE(std::filesystem::is_empty(frame.folder.path));
}

TEST(FrameRecorder, StopByAnotherThreadEndsItAndLasts) {
  StagedFrame frame(1 << 20);
  Stage& stage = frame.stage;
  std::atomic<bool> rendering{false};
  RecordOptions options;
  options.progress = [&](const RecordProgress&) { rendering = true; };
  std::thread other([&] {
    while (!rendering) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    stage.delegate->Stop();
  });
  const RecordResult result = RecordFrame(stage.index.get(), &stage.scene, "/settings", options);
  other.join();
  EXPECT_EQ(result.status, RecordStatus::interrupted);
  EXPECT_EQ(result.stats.at("state").text_or(""), "stopped");
  EXPECT_EQ(result.written.size(), 1u) << "what was rendered before is written";
  EXPECT_TRUE(stage.delegate->IsStopped()) << "only the thread that stopped it may restart it";
}

// The recorder itself stops the delegate for a moment to end a render that is cancelled.
TEST(FrameRecorder, AStopDuringItsOwnLasts) {
  StagedFrame frame(1 << 20);
  Stage& stage = frame.stage;
  std::atomic<bool> cancel{false};
  RecordOptions options;
  options.cancel = &cancel;
  bool stopped = false;
  options.progress = [&](const RecordProgress&) {
    cancel = true;
    if (!stage.delegate->IsStopped()) return;
    std::thread([&] { stage.delegate->Stop(); }).join();
    stopped = true;
  };
  EXPECT_EQ(RecordFrame(stage.index.get(), &stage.scene, "/settings", options).status, RecordStatus::interrupted);
  ASSERT_TRUE(stopped);
  EXPECT_TRUE(stage.delegate->IsStopped()) << "only the thread that stopped it may restart it";
  stage.delegate->Restart();
  EXPECT_FALSE(stage.delegate->IsStopped());
}

// Pulling a mesh takes until the delegate is stopped; another thread then stops it, too.
class StoppingScene : public RetainedSceneDelegate {
 public:
  explicit StoppingScene(RenderDelegate* delegate) : delegate_(delegate) {}
  MeshTopology GetMeshTopology(const Path& id) override {
    for (int i = 0; i < 5000 && !delegate_->IsStopped(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    std::thread([&] { delegate_->Stop(); }).join();
    return RetainedSceneDelegate::GetMeshTopology(id);
  }

 private:
  RenderDelegate* delegate_;
};

TEST(FrameRecorder, AStopDuringItsOwnInSyncLasts) {
  const Folder folder;
  Stage stage;
  StoppingScene scene(stage.delegate);
  scene.SetMesh("/quad", Stage::quad());
  scene.SetRenderSettings("/settings", settings_for(folder.path + "/frame.exr", 1));
  scene.Populate(stage.index.get());
  const std::atomic<bool> cancel{true};
  RecordOptions options;
  options.cancel = &cancel;
  EXPECT_EQ(RecordFrame(stage.index.get(), &scene, "/settings", options).status, RecordStatus::interrupted);
  EXPECT_TRUE(stage.delegate->IsStopped()) << "only the thread that stopped it may restart it";
  scene.Depopulate();
}

TEST(FrameRecorder, AStoppedDelegateStaysStoppedAndWritesNothing) {
  const Folder folder;
  Stage stage;
  stage.add_basic_scene();
  stage.scene.SetRenderSettings("/settings", settings_for(folder.path + "/frame.exr", 2));
  stage.delegate->Stop();
  EXPECT_EQ(RecordFrame(stage.index.get(), &stage.scene, "/settings", {}).status, RecordStatus::interrupted);
  EXPECT_TRUE(stage.delegate->IsStopped());
  EXPECT_TRUE(std::filesystem::is_empty(folder.path));
  stage.delegate->Restart();
  EXPECT_EQ(RecordFrame(stage.index.get(), &stage.scene, "/settings", {}).status, RecordStatus::done);
}

}  // namespace
}  // namespace alabaster::hd::host
