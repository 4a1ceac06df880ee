// Restarts of a render, changes without a restart, and the end of a render.
#include <gtest/gtest.h>

#include <chrono>
#include <optional>
#include <set>
#include <thread>

#include "testenv/support/failing_memory.h"
#include "testenv/support/stage.h"

namespace alabaster::hd {
namespace {

struct Shot {
  Stage stage;
  RenderBuffer* buffer;
  std::unique_ptr<RenderPass> pass;
  RenderPassState state;

  explicit Shot(int samples = 1, int size = 8) : stage({{"samples", samples}}) {
    stage.add_basic_scene();
    buffer = stage.add_buffer("/b", size, size, Format::float32vec4);
    stage.index->SyncAll();
    stage.wait_for_scene();
    pass = stage.delegate->CreateRenderPass();
    state = Stage::state_for(size, size, "color", buffer);
  }
  bool finish() { return Stage::finish(*pass, state); }
  /// True if one more Execute restarts the render.
  bool restarts() {
    pass->Execute(state);
    return !pass->IsConverged();
  }
};

constexpr int kEndless = 1 << 20;

/// The texts of the reports of a code.
std::vector<std::string> texts_of(Stage& stage, const std::string& code) {
  std::vector<std::string> texts;
  for (const Diagnostic& d : stage.take_diagnostics())
    if (d.code == code) texts.push_back(d.where + ": " + d.text);
  return texts;
}

TEST(RenderPass, AnAovThatTheRendererLacksIsReportedWithTheNearest) {
  Shot s;
  s.state.aovBindings.push_back({"cameraDeth", s.buffer, {}});
  s.state.aovBindings.push_back({"edgeId", s.buffer, {}});
  EXPECT_TRUE(s.finish()) << "the others are drawn";
  EXPECT_EQ(texts_of(s.stage, "pass.binding"),
            (std::vector<std::string>{
                "cameraDeth: the renderer has no such AOV, and its buffer is not drawn; did you mean 'cameraDepth'?",
                "edgeId: the renderer has no such AOV, and its buffer is not drawn"}));
  for (const char* name : {"primId", "instanceId", "elementId", "Neye", "Peye", "depth", "cameraDepth", "normal"})
    s.state.aovBindings.push_back({name, s.buffer, {}});
  s.state.aovBindings.erase(s.state.aovBindings.begin() + 1, s.state.aovBindings.begin() + 3);
  EXPECT_TRUE(s.finish());
  EXPECT_TRUE(s.stage.take_diagnostics().empty()) << "names of Hydra's hosts";
}

// promise: embedding.viewport.sizes
TEST(RenderPass, AFrameThatDoesNotLieInItsBufferIsReported) {
  Shot s(1, 16);
  s.state.framing.dataWindow = {2, 2, 10, 10};
  EXPECT_TRUE(s.finish());
  EXPECT_TRUE(s.stage.take_diagnostics().empty()) << "Hydra: a buffer may be larger than the data window";
  s.state.framing.dataWindow = {0, 0, 24, 12};
  EXPECT_TRUE(s.finish());
  EXPECT_TRUE(s.finish()) << "reported once";
  const std::string end = ": the part outside of the buffer is not shown; allocate the buffer in the size of the frame";
  EXPECT_EQ(
      texts_of(s.stage, "pass.size"),
      std::vector<std::string>{"/b: the buffer of AOV 'color' has 16 x 16 pixels, but the frame has 24 x 12" + end});
  s.state.framing.dataWindow = {-4, 0, 12, 16};
  EXPECT_TRUE(s.finish());
  EXPECT_EQ(
      texts_of(s.stage, "pass.size"),
      std::vector<std::string>{
          "/b: the buffer of AOV 'color' has 16 x 16 pixels, but the frame has 16 x 16 from pixel (-4, 0)" + end});
}

TEST(RenderPass, ACameraThatDoesNotExistIsReportedWithTheNearest) {
  Shot s;
  s.state.camera = "/camrea";
  EXPECT_TRUE(s.finish());
  EXPECT_EQ(s.pass->GetState(), PassState::failed);
  EXPECT_EQ(texts_of(s.stage, "pass.failed"),
            std::vector<std::string>{"/camrea: camera /camrea does not exist; did you mean '/camera'?"});
}

TEST(RenderPass, BeginsOnceItsSceneIsThereWithoutAnotherExecute) {
  Stage stage({{"samples", 1}});
  stage.add_basic_scene();
  RenderBuffer* buffer = stage.add_buffer("/b", 8, 8, Format::float32vec4);
  stage.index->SyncAll();
  const auto pass = stage.delegate->CreateRenderPass();
  pass->Execute(Stage::state_for(8, 8, "color", buffer));
  for (int i = 0; i < 20000 && stage.stat("fractionDone") < 1; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  EXPECT_EQ(stage.stat("fractionDone"), 1);
  buffer->Resolve();
  EXPECT_EQ(Stage::pixels<float>(buffer)[4 * 36 + 3], 1);
}

// The scene is there when the buffer is gone: the host destroyed it before another Execute named others.
TEST(RenderPass, ABufferThatIsDestroyedBeforeTheSceneIsThereIsNotTouched) {
  for (int edit = 0; edit < 10; ++edit) {
    Stage stage({{"samples", 1}});
    stage.add_basic_scene();
    RenderBuffer* buffer = stage.add_buffer("/b", 8, 8, Format::float32vec4);
    stage.index->SyncAll();
    const auto pass = stage.delegate->CreateRenderPass();
    pass->Execute(Stage::state_for(8, 8, "color", buffer));
    stage.scene.Remove("/b");
    EXPECT_TRUE(pass->WaitForConvergence(20));
  }
}

// A valid value that is not the default.
Value another_value(const RenderSettingDescriptor& setting) {
  const Value& now = setting.defaultValue;
  if (const bool* b = now.get<bool>()) return !*b;
  if (!setting.choices.empty())
    return setting.choices.front() == now.text_or("") ? setting.choices.back() : setting.choices.front();
  if (setting.key == Token("samples")) return 5;
  if (setting.key == Token("timeLimit")) return 1000.0f;
  if (now.get<float>()) return 0.5f;
  return now.number_or(0) == 1 ? 2 : 1;
}

TEST(RenderPass, SettingsHaveTheEffectThatTheySay) {
  Shot s(4, 96);
  ASSERT_TRUE(s.finish());
  const double all = s.stage.stat("rays.camera");
  std::set<SettingEffect> seen;
  for (const RenderSettingDescriptor& setting : s.stage.delegate->GetRenderSettingDescriptors()) {
    if (setting.key == Token("denoise")) continue;           // needs a library
    if (setting.effect == SettingEffect::resyncs) continue;  // needs a mesh that is refined
    seen.insert(setting.effect);
    s.stage.delegate->SetRenderSetting(setting.key, another_value(setting));
    const bool restarts = s.restarts();
    const double kept = s.stage.stat("rays.camera");
    EXPECT_EQ(restarts, setting.effect != SettingEffect::live) << setting.name;
    EXPECT_EQ(kept >= all, setting.effect != SettingEffect::restarts) << setting.name;
    EXPECT_TRUE(s.finish()) << setting.name;
    s.stage.delegate->SetRenderSetting(setting.key, setting.key == Token("samples") ? Value(4) : Value());
    EXPECT_TRUE(s.finish()) << setting.name;
  }
  EXPECT_EQ(seen.size(), 3u);
}

TEST(RenderPass, TransformAndMaterialEditsRefineNothing) {
  Shot s;
  const double refined = s.stage.stat("sync.refineSeconds"), built = s.stage.stat("sync.bvhSeconds");
  const double refined_wall = s.stage.stat("sync.refineWallSeconds");
  EXPECT_GT(refined, 0);
  EXPECT_GT(refined_wall, 0);
  EXPECT_GT(s.stage.stat("sync.bvhWallSeconds"), 0);
  host::MeshDescription mesh = Stage::quad();
  mesh.transform[3][2] = -1;
  mesh.material = "/nowhere";
  s.stage.scene.SetMesh("/quad", mesh);
  s.stage.index->SyncAll();
  EXPECT_EQ(s.stage.stat("sync.refineSeconds"), refined);
  EXPECT_EQ(s.stage.stat("sync.bvhSeconds"), built);
  EXPECT_EQ(s.stage.stat("sync.refineWallSeconds"), refined_wall);
  EXPECT_EQ(s.stage.count("mesh.material"), 1u);
}

// 2^40 pixels of 156 bytes: about 171 TB.
TEST(RenderPass, AFrameBeyondTheMemoryLimitIsRefused) {
  Shot s;
  s.state.framing.displayMax = {1 << 20, 1 << 20};
  s.state.framing.dataWindow = {0, 0, 1 << 20, 1 << 20};
  s.pass->Execute(s.state);
  EXPECT_TRUE(s.pass->IsConverged());
  EXPECT_EQ(s.pass->GetState(), PassState::failed);
  const std::string error = s.stage.text_stat("error");
  EXPECT_NE(error.find("a frame of 1048576 x 1048576 pixels needs 163"), std::string::npos) << error;
  EXPECT_NE(error.find("a data window (crop)"), std::string::npos) << error;
  EXPECT_EQ(s.stage.count("pass.failed"), 1u);
  s.state.framing.dataWindow = {0, 0, 8, 8};  // a crop of it fits
  EXPECT_TRUE(s.finish());
  EXPECT_EQ(s.pass->GetState(), PassState::converged);
}

// The second refusal meets the report of the first.
// A thread that does not render may take the refusal, as while the machine is busy: then another render is begun.
TEST(RenderPass, ARenderThatFailsOnItsOwnThreadsConvergesAndSaysWhy) {
  for (const int refusals : {1, 2}) {
    std::optional<Shot> shot;
    for (int attempt = 0; attempt < 20 && !(shot && shot->pass->GetState() == PassState::failed); ++attempt) {
      shot.emplace(16);
      const testing::FailingMemoryElsewhere memory(refusals);
      shot->pass->Execute(shot->state);
      ASSERT_TRUE(shot->pass->WaitForConvergence(20));
    }
    Shot& s = *shot;
    EXPECT_EQ(s.pass->GetState(), PassState::failed);
    for (int i = 0; i < 3; ++i) s.pass->Execute(s.state);
    EXPECT_TRUE(s.pass->IsConverged());
    EXPECT_TRUE(s.buffer->IsConverged());
    EXPECT_EQ(s.stage.count("pass.failed"), 1u) << "told once";
    const std::string error = s.stage.text_stat("error");
    EXPECT_TRUE(error == "rendering failed: std::bad_alloc" || (refusals == 2 && error == "out of memory")) << error;
    s.stage.delegate->SetRenderSetting("seed", 1);
    EXPECT_TRUE(s.finish());
    EXPECT_EQ(s.pass->GetState(), PassState::converged);
    EXPECT_EQ(s.stage.text_stat("error"), "");
  }
}

TEST(RenderPass, TheSettingsPrimGivesCameraAndSettingsAndTheHostOverrides) {
  Shot s;
  RenderSettingsDescription settings;
  settings.camera = "/camera";
  settings.settings = {{"samples", 3}, {"maxDepth", 2}};
  s.stage.scene.SetRenderSettings("/settings", settings);
  s.stage.index->SyncAll();
  EXPECT_EQ(s.stage.delegate->GetRenderSetting("maxDepth").number_or(0), 2);
  EXPECT_EQ(s.stage.delegate->GetRenderSetting("samples").number_or(0), 1) << "set by the host";
  s.stage.delegate->SetRenderSetting("samples", {});
  EXPECT_EQ(s.stage.delegate->GetRenderSetting("samples").number_or(0), 3);
  s.state.camera = Path();
  EXPECT_TRUE(s.finish());
  EXPECT_EQ(s.pass->GetState(), PassState::converged);
}

TEST(BackgroundControl, ARestartThatFollowsNoStopLeavesAllRendersRunning) {
  Shot s(kEndless);
  RenderBuffer* other_buffer = s.stage.add_buffer("/other", 8, 8, Format::float32vec4);
  s.stage.index->SyncAll();
  const auto other = s.stage.delegate->CreateRenderPass();
  s.pass->Execute(s.state);
  other->Execute(Stage::state_for(8, 8, "color", other_buffer));
  s.stage.delegate->Restart();
  EXPECT_EQ(s.pass->GetState(), PassState::rendering);
  EXPECT_EQ(other->GetState(), PassState::rendering);
  EXPECT_FALSE(other->WaitForConvergence(0.05));
}

TEST(BackgroundControl, APauseFromBeforeHoldsTheFirstRenderAndAnEditEndsIt) {
  Shot s(kEndless);
  s.stage.delegate->Pause();
  s.pass->Execute(s.state);
  EXPECT_EQ(s.pass->GetState(), PassState::paused);
  host::MeshDescription mesh = Stage::quad();
  mesh.transform[3][0] = 1;
  s.stage.scene.SetMesh("/quad", mesh);
  s.stage.index->SyncAll();
  s.stage.wait_for_scene();
  EXPECT_TRUE(s.stage.delegate->IsPaused()) << "an edit ends a pause only through Execute";
  s.pass->Execute(s.state);
  EXPECT_FALSE(s.stage.delegate->IsPaused());
  EXPECT_EQ(s.pass->GetState(), PassState::rendering);
}

TEST(RenderPass, AFramingThatCannotBeRenderedFailsAndSaysWhy) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  const auto error_of = [](const std::function<void(Framing&)>& change) {
    Shot s;
    const RenderPassState sound = s.state;
    change(s.state.framing);
    s.pass->Execute(s.state);
    EXPECT_TRUE(s.pass->IsConverged());
    EXPECT_EQ(s.pass->GetState(), PassState::failed);
    s.pass->Execute(s.state);
    EXPECT_EQ(s.stage.count("pass.failed"), 1u) << "told once";
    const std::string error = s.stage.text_stat("error");
    s.state = sound;
    EXPECT_TRUE(s.finish());
    EXPECT_EQ(s.pass->GetState(), PassState::converged);
    return error;
  };
  EXPECT_NE(error_of([](Framing& f) { f.pixelAspectRatio = kNan; }).find("pixel aspect ratio"), std::string::npos);
  EXPECT_NE(error_of([](Framing& f) { f.displayMax.x = -8; }).find("display window"), std::string::npos);
  EXPECT_NE(error_of([](Framing& f) { f.dataWindow.maxY = -3; }).find("data window"), std::string::npos);
}

}  // namespace
}  // namespace alabaster::hd
