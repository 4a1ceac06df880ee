// Passes that are written as archives: the program draws the same picture.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <limits>

#include "delegate/archive/archive.h"
#include "delegate/description/render_description.h"
#include "testenv/support/build_paths.h"
#include "testenv/support/stage.h"

namespace alabaster::hd::archive {
namespace {

using description::LoadOptions;
using description::LoadScene;
using description::SceneFile;

class WritePassTest : public ::testing::Test {
 protected:
  static constexpr int kWidth = 24, kHeight = 16;
  using Pixels = std::vector<float>;

  WritePassTest() {
    folder_ = std::filesystem::temp_directory_path() / ("write_pass_" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
    state_.camera = "/camera";
    state_.framing.displayMax = {float(kWidth), float(kHeight)};
    state_.framing.dataWindow = {0, 0, kWidth, kHeight};
  }
  ~WritePassTest() override { std::filesystem::remove_all(folder_); }

  std::string file() const { return (folder_ / "copy.alab").string(); }
  std::string write() { return WritePass(file(), stage_.scene.GetPrims(), state_, settings_); }

  static Pixels picture(Stage& stage, RenderPassState state, const std::map<Token, Value>& settings) {
    for (const auto& [name, value] : settings) stage.delegate->SetRenderSetting(name, value);
    const Rect2i& window = state.framing.dataWindow;
    RenderBuffer* const color = stage.add_buffer("/color", window.width(), window.height(), Format::float32vec4);
    state.aovBindings = {{"color", color, {}}};
    stage.index->SyncAll();
    const auto pass = stage.delegate->CreateRenderPass();
    EXPECT_TRUE(Stage::finish(*pass, state));
    return Stage::pixels<float>(color);
  }
  Pixels picture() { return picture(stage_, state_, settings_); }

  /// The picture of a file, with its own camera, window, purposes and settings.
  static Pixels picture_of(const std::string& archive, bool allow_outside = true) {
    Stage stage;
    LoadOptions options;
    options.allow_outside = allow_outside;
    const SceneFile loaded = LoadScene(
        archive, &stage.scene, [](const Diagnostic& d) { ADD_FAILURE() << d.where << ": " << d.text; }, options);
    if (!loaded.ok) return {};
    const RenderSettingsDescription settings = stage.scene.GetRenderSettings(loaded.settings);
    RenderPassState state;
    state.camera = settings.camera;
    state.windowPolicy = settings.windowPolicy;
    const Vec2f corner(float(settings.window().minX), float(settings.window().minY));
    state.framing.displayMin = -corner;
    state.framing.displayMax = Vec2f(float(settings.width), float(settings.height)) - corner;
    state.framing.dataWindow = {0, 0, settings.window().width(), settings.window().height()};
    state.framing.pixelAspectRatio = settings.pixelAspectRatio;
    state.renderTags.clear();
    for (const Token& purpose : settings.includedPurposes)
      state.renderTags.push_back(purpose == Token("default") ? Token("geometry") : purpose);
    std::map<Token, Value> own;
    for (const auto& [name, value] : settings.settings) own[Token(name)] = value;
    return picture(stage, state, own);
  }

  /// Writes the scene, and expects the same picture of the file.
  void expect_same_picture() {
    ASSERT_EQ(write(), "");
    const Pixels before = picture(), after = picture_of(file());
    ASSERT_EQ(before.size(), after.size());
    size_t differ = 0;
    for (size_t i = 0; i < before.size(); ++i) differ += before[i] != after[i];
    EXPECT_EQ(differ, 0u) << "of " << before.size() << " numbers";
    EXPECT_GT(*std::max_element(before.begin(), before.end()), 0) << "there is something to compare";
  }

  std::filesystem::path folder_;
  Stage stage_;
  RenderPassState state_;
  std::map<Token, Value> settings_{{"samples", int64_t(4)}, {"threads", 2}};
};

class BundledScenes : public WritePassTest, public ::testing::WithParamInterface<const char*> {};

// promise: pipeline.archive.cpp
TEST_P(BundledScenes, HaveTheSamePicture) {
  LoadOptions options;
  options.overrides = {"resolution=[24,16]"};
  const SceneFile loaded = LoadScene(
      testing::source_file("testenv/scenes/") + GetParam(), &stage_.scene,
      [](const Diagnostic& d) { ADD_FAILURE() << d.where << ": " << d.text; }, options);
  ASSERT_TRUE(loaded.ok);
  const RenderSettingsDescription settings = stage_.scene.GetRenderSettings(loaded.settings);
  state_.camera = settings.camera;
  state_.windowPolicy = settings.windowPolicy;
  for (const auto& [key, value] : settings.settings) settings_.emplace(key, value);
  expect_same_picture();
  // With its images it needs no other file.
  host::RetainedSceneDelegate read;
  const ReadResult result = ReadArchive(file(), &read, {}, {.allow_outside = true});
  for (const auto& [path, prim] : read.GetAllRenderSettings()) {
    RenderSettingsDescription without = prim;
    without.products.clear();
    read.SetRenderSettings(path, without);
  }
  ASSERT_EQ(WriteArchive(file(), read.GetPrims(), result.info, {.embed_images = true}), "");
  EXPECT_EQ(picture_of(file(), false), picture());
}

INSTANTIATE_TEST_SUITE_P(Scenes, BundledScenes,
                         ::testing::Values("backlit/backlit.json", "lights/lights.json", "sample/sample.json",
                                           "hard_light/hard_light.json", "thick_thin/thick_thin.json",
                                           "skin_closeup/skin_closeup.json", "still_life/still_life.json",
                                           "mixed_no_subsurface/mixed_no_subsurface.json",
                                           "dome_high_contrast/dome_high_contrast.json"));

MaterialNetwork plain(std::map<Token, Value> parameters) {
  MaterialNetwork network;
  network.nodes["/s"] = {"AlabasterDisney", std::move(parameters), {}};
  network.terminals["surface"] = {"/s", "surface"};
  return network;
}

// Each of these differs from what files for exchange hold.
TEST_F(WritePassTest, UnusualMeshesHaveTheSamePicture) {
  stage_.add_basic_scene();
  stage_.scene.SetMaterial("/wax", plain({{"baseColor", Vec3f(0.8f, 0.5f, 0.3f)}, {"scatterDistance", Vec3f(0.5f)}}));
  stage_.scene.SetMaterial("/red", plain({{"baseColor", Vec3f(0.8f, 0.1f, 0.1f)}}));
  host::MeshDescription mesh = Stage::quad();
  mesh.topology.orientation = "leftHanded", mesh.cullStyle = CullStyle::front, mesh.material = "/wax";
  mesh.transform = Matrix4d(0.3, 0, 0.1, 0, 0, 0.3, 0, 0, -0.1, 0, 0.3, 0, 1, 0, 0.5, 1);
  stage_.scene.SetMesh("/left", mesh);
  mesh = Stage::quad();
  mesh.topology.scheme = "catmullClark", mesh.subdivTags.creaseMethod = "chaikin";
  mesh.subdivTags.creaseIndices = {0, 1, 2}, mesh.subdivTags.creaseLengths = {3},
  mesh.subdivTags.creaseWeights = {2, 3};
  mesh.topology.geomSubsets = {{"/cage/half", "/red", {0}}};
  mesh.transform[3][0] = -1.2, mesh.transform[3][2] = 0.5;
  stage_.scene.SetMesh("/cage", mesh);
  mesh = Stage::quad();
  const Value points = mesh.primvars["points"].value;
  mesh.primvarSamples["points"] = {{-0.5, 0.5}, {points, Array<Vec3f>{{-1, -1, 0}, {1, -1, 1}, {1, 1, 1}, {-1, 1, 0}}}};
  mesh.primvars["displayColor"] = {
      Interpolation::vertex, "color", Array<Vec3f>{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}}, {}};
  mesh.instancer = "/many";
  stage_.scene.SetMesh("/moving", mesh);
  host::InstancerDescription many;
  many.primvars["hydra:instanceTransforms"] =
      Array<Matrix4d>{Matrix4d(0.2, 0.1, 0, 0, 0, 0.2, 0, 0, 0, 0, 0.2, 0, 0, 1, 0.5, 1),
                      Matrix4d(0.2, 0, 0, 0, 0, 0.2, 0, 0, 0, 0, 0.2, 0, 0, -1, 0.5, 1)};
  many.indices["/moving"] = {1, 0, 7};
  many.categories = {{"key"}};
  stage_.scene.SetInstancer("/many", many);
  stage_.scene.SetLight("/key", {.type = "sphereLight",
                                 .transform = Matrix4d().setTranslation(Vec3d(1, 1, 2)),
                                 .parameters = {{"radius", 0.3f}, {"intensity", 20.0f}, {"lightLink", Token("key")}}});
  host::CameraDescription camera = stage_.scene.GetCameras().at("/camera");
  camera.parameters["shutterOpen"] = -0.25f, camera.parameters["shutterClose"] = 0.25f;
  stage_.scene.SetCamera("/camera", camera);
  expect_same_picture();
}

// promise: pipeline.archive.cpp
TEST_F(WritePassTest, WindowsSelectionsAndFreeCamerasAreThoseOfThePass) {
  stage_.add_basic_scene();
  host::MeshDescription mesh = Stage::quad();
  mesh.transform = Matrix4d(0.3, 0, 0.1, 0, 0, 0.3, 0, 0, -0.1, 0, 0.3, 0, 1, 0, 0.5, 1);
  stage_.scene.SetMesh("/group/excluded", mesh);
  mesh.transform[3][0] = -1, mesh.renderTag = "guide";
  stage_.scene.SetMesh("/guide", mesh);
  mesh.transform[3][0] = 0, mesh.visible = false;
  stage_.scene.SetMesh("/hidden", mesh);
  state_.collection.excludePaths = {"/group"};
  state_.renderTags = {"geometry", "guide"};
  state_.framing.displayMin = {-3, -5}, state_.framing.displayMax = {29, 19};
  state_.framing.pixelAspectRatio = 1.5f;
  state_.windowPolicy = WindowPolicy::fit;
  expect_same_picture();
  state_.freeCamera = stage_.scene.GetCameras().at("/camera");
  state_.freeCamera->transform[3][0] = 0.7;
  state_.camera = {};
  expect_same_picture();
}

TEST_F(WritePassTest, DarkScenesStayDark) {
  stage_.add_basic_scene();
  stage_.scene.Remove("/dome");
  ASSERT_EQ(write(), "");
  const Pixels after = picture_of(file());
  EXPECT_EQ(after, picture()) << "no light is added";
}

TEST_F(WritePassTest, SaysWhyNothingIsWritten) {
  stage_.add_basic_scene();
  const auto fault = [&](void (*edit)(RenderPassState&, std::map<Token, Value>&)) {
    RenderPassState state = state_;
    std::map<Token, Value> settings = settings_;
    edit(state, settings);
    return WritePass(file(), stage_.scene.GetPrims(), state, settings);
  };
  using State = RenderPassState;
  using Settings = std::map<Token, Value>;
  EXPECT_EQ(fault([](State& s, Settings&) { s.camera = "/gone"; }),
            "/gone is no camera of the scene; name one that is");
  EXPECT_EQ(fault([](State& s, Settings&) { s.camera = {}; }),
            "the pass has no camera; name one of the scene, or give one");
  EXPECT_NE(fault([](State& s, Settings&) { s.framing.displayMax.x += 0.5f; }).find("ends within pixels"),
            std::string::npos);
  EXPECT_NE(fault([](State& s, Settings&) { s.framing.dataWindow = {}; }).find("no pixels"), std::string::npos);
  EXPECT_EQ(fault([](State&, Settings& s) { s["sampels"] = int64_t(4); }),
            "/render: there is no setting 'sampels'; did you mean 'samples'?");
  MaterialNetwork broken = plain({});
  broken.terminals["displacement"] = {"/d", "out"};
  stage_.scene.SetMaterial("/broken", broken);
  EXPECT_EQ(write(), "/broken: displacement names /d, which is no node of the material");
  EXPECT_TRUE(std::filesystem::is_empty(folder_));
}

}  // namespace
}  // namespace alabaster::hd::archive
