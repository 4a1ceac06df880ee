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

// The size and the mean of alpha of each picture, in order.
struct Pictures {
  std::vector<std::pair<Vec2i, double>> all;
  RecordOptions options() {
    RecordOptions o;
    o.picture = [this](const ProductImage& image) {
      const auto& rgba = image.aovs.at("color").floats;
      double alpha = 0;
      for (size_t i = 3; i < rgba.size(); i += 4) alpha += double(rgba[i]);
      const Rect2i window = image.framing.dataWindow;
      all.push_back({{window.width(), window.height()}, alpha / double(rgba.size() / 4)});
    };
    return o;
  }
};

// promise: pipeline.products
TEST(FrameRecorder, EachCameraAndSizeOfTheProductsIsAPictureOnce) {
  const Folder folder;
  Stage stage;
  stage.add_basic_scene();
  host::CameraDescription away = stage.scene.GetCameras().at("/camera");
  away.transform[3][0] = 100;
  stage.scene.SetCamera("/away", away);
  RenderSettingsDescription settings = settings_for(folder.path + "/a.png", 2);
  settings.crop = Rect2i{0, 0, 12, 16};
  settings.products.resize(5, settings.products[0]);
  for (size_t i = 1; i < 5; ++i) settings.products[i].file = folder.path + "/" + std::to_string(i) + ".png";
  settings.products[1].camera = "/away";
  settings.products[2].camera = "/camera";
  settings.products[3].width = 48;
  settings.products[3].height = 33;
  settings.products[4].camera = "/away";
  stage.scene.SetRenderSettings("/settings", settings);
  Pictures pictures;
  const RecordResult result = RecordFrame(stage.index.get(), &stage.scene, "/settings", pictures.options());
  EXPECT_EQ(result.status, RecordStatus::done);
  EXPECT_EQ(result.written.size(), 5u);
  ASSERT_EQ(pictures.all.size(), 3u) << "two cameras, and another size of the first";
  EXPECT_EQ(pictures.all[0].first, Vec2i(12, 16));
  EXPECT_EQ(pictures.all[2].first, Vec2i(24, 33)) << "half of 48 x 33";
  EXPECT_GT(pictures.all[0].second, 0.1);
  EXPECT_EQ(pictures.all[1].second, 0) << "looks past the quad";
  EXPECT_NEAR(pictures.all[2].second, pictures.all[0].second, 0.03);
  EXPECT_FALSE(stage.index->Has("/settings/buffer_color"));
}

TEST(FrameRecorder, APauseFromBeforeEnds) {
  const Folder folder;
  Stage stage;
  stage.add_basic_scene();
  stage.scene.SetRenderSettings("/settings", settings_for(folder.path + "/a.png", 1));
  stage.delegate->Pause();
  EXPECT_EQ(RecordFrame(stage.index.get(), &stage.scene, "/settings", {}).status, RecordStatus::done);
}

// promise: farm.resume.one_render, pipeline.products
TEST(FrameRecorder, PicturesOfSeveralCamerasHaveNoCheckpoint) {
  const Folder folder;
  Stage stage;
  stage.add_basic_scene();
  RenderSettingsDescription settings = settings_for(folder.path + "/a.png", 1);
  settings.products.push_back(settings.products[0]);
  settings.products[1].height = 20;
  stage.scene.SetRenderSettings("/settings", settings);
  RecordOptions options;
  options.checkpoint = folder.path + "/frame.checkpoint";
  std::vector<std::string> codes;
  options.diagnostics = [&](const Diagnostic& d) { codes.push_back(d.code); };
  EXPECT_EQ(RecordFrame(stage.index.get(), &stage.scene, "/settings", options).status, RecordStatus::input_failed);
  EXPECT_EQ(codes, std::vector<std::string>{"record.checkpoint"});
  settings.products[1].camera = "/nowhere";
  stage.scene.SetRenderSettings("/settings", settings);
  EXPECT_EQ(RecordFrame(stage.index.get(), &stage.scene, "/settings", {}).status, RecordStatus::input_failed);
}

// A quad that moves by its own width while the shutter is open, and the same at the frame's time.
// promise: pipeline.products
TEST(FrameRecorder, ProductsMayLeaveOutMotionBlurAndDepthOfField) {
  const Folder folder;
  Stage stage;
  stage.add_basic_scene();
  MeshDescription mesh = Stage::quad();
  Matrix4d right;
  right[3][0] = 1;
  mesh.transformSamples = {{0, 1}, {Matrix4d(), right}};
  stage.scene.SetMesh("/quad", mesh);
  CameraDescription camera = stage.scene.GetCameras().at("/camera");
  camera.parameters["shutterClose"] = 1.0;
  camera.parameters["fStop"] = 0.2f;
  camera.parameters["focusDistance"] = 1.0f;
  stage.scene.SetCamera("/camera", camera);
  RenderSettingsDescription settings = settings_for(folder.path + "/a.png", 16);
  settings.products.resize(3, settings.products[0]);
  settings.products[1].disableDepthOfField = true;
  settings.products[1].file = folder.path + "/b.png";
  settings.products[2].disableMotionBlur = settings.products[2].disableDepthOfField = true;
  settings.products[2].file = folder.path + "/c.png";
  stage.scene.SetRenderSettings("/settings", settings);
  std::vector<int> partly;  // pixels that are neither empty nor covered
  RecordOptions options;
  options.picture = [&](const ProductImage& image) {
    const auto& rgba = image.aovs.at("color").floats;
    partly.push_back(0);
    for (size_t i = 3; i < rgba.size(); i += 4) partly.back() += rgba[i] > 0 && rgba[i] < 1;
  };
  EXPECT_EQ(RecordFrame(stage.index.get(), &stage.scene, "/settings", options).status, RecordStatus::done);
  ASSERT_EQ(partly.size(), 3u);
  EXPECT_NE(partly[0], partly[1]);
  EXPECT_GT(partly[1], partly[2] + 20);
  EXPECT_LT(partly[2], 70) << "the outline";
}

// promise: pipeline.purposes
TEST(FrameRecorder, DrawsTheIncludedPurposes) {
  const Folder folder;
  Stage stage;
  stage.add_basic_scene();
  MeshDescription proxy = Stage::quad();
  proxy.renderTag = "proxy";
  proxy.transform = Matrix4d().setScale(1.5);
  stage.scene.SetMesh("/proxy", proxy);
  RenderSettingsDescription settings = settings_for(folder.path + "/a.png", 2);
  Pictures pictures;
  for (const std::vector<Token>& purposes : {settings.includedPurposes, std::vector<Token>{"default", "proxy"}}) {
    settings.includedPurposes = purposes;
    stage.scene.SetRenderSettings("/settings", settings);
    EXPECT_EQ(RecordFrame(stage.index.get(), &stage.scene, "/settings", pictures.options()).status, RecordStatus::done);
  }
  ASSERT_EQ(pictures.all.size(), 2u);
  EXPECT_GT(pictures.all[1].second, 1.5 * pictures.all[0].second);
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
