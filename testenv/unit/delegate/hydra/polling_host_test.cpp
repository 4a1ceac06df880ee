// A Hydra host on the plain door, of the kind that executes once in a frame, and then asks for progress and convergence
// and maps without a pause, as Blender's HydraRenderEngine does.
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <filesystem>

#include "delegate/description/render_description.h"
#include "delegate/hydra/host_values.h"
#include "delegate/hydra/pass_driver.h"
#include "delegate/hydra/scene_capture.h"
#include "delegate/hydra/translated_scene.h"
#include "testenv/support/stage.h"

namespace alabaster::hydra {
namespace {

using hd::Array;
using hd::Path;
using hd::Token;
using hd::Value;
using hd::Vec3f;

constexpr int kSize = 32;

/// The scene as hosts give it: triangles with normals at their corners, Standard Surface, parameters of lights with and
/// without "inputs:".
class HostScene final : public TranslatedScene {
 public:
  explicit HostScene(bool domes_visible = true) : TranslatedScene(domes_visible) {}

  hd::MeshTopology GetMeshTopology(const Path&) override {
    hd::MeshTopology topology;
    topology.faceVertexCounts = {3, 3};
    topology.faceVertexIndices = {0, 1, 2, 0, 2, 3};
    return topology;
  }
  hd::SubdivTags GetSubdivTags(const Path&) override { return {}; }
  hd::DisplayStyle GetDisplayStyle(const Path&) override { return {}; }
  hd::Matrix4d GetTransform(const Path& id) override {
    hd::Matrix4d matrix;
    if (id == Path("/scene/O_mesh")) matrix[3][0] = 0.25;
    return matrix;
  }
  bool GetVisible(const Path&) override { return true; }
  bool GetDoubleSided(const Path&) override { return true; }
  Token GetRenderTag(const Path&) override { return "geometry"; }
  Path GetMaterialId(const Path&) override { return "/scene/M_wax"; }
  std::vector<hd::PrimvarDescriptor> GetPrimvarDescriptors(const Path&) override {
    return {{"points", hd::Interpolation::vertex, "point"}, {"normals", hd::Interpolation::faceVarying, "normal"}};
  }
  Value GetPrimvar(const Path&, const Token& name, Array<int32_t>*) override {
    if (name == Token("points")) return Array<Vec3f>{{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
    return name == Token("normals") ? Value(Array<Vec3f>(std::vector<Vec3f>(6, Vec3f(0, 0, 1)))) : Value();
  }
  Path GetInstancerId(const Path&) override { return {}; }
  hd::Matrix4d GetInstancerTransform(const Path&) override { return {}; }
  Array<int32_t> GetInstanceIndices(const Path&, const Path&) override { return {}; }
  Value GetCameraParamValue(const Path&, const Token&) override { return {}; }
  hd::RenderBufferDescriptor GetRenderBufferDescriptor(const Path&) override { return {}; }
  hd::RenderSettingsDescription GetRenderSettings(const Path&) override { return {}; }

 protected:
  Token GetHostLightType(const Path& id) override { return id == Path("/scene/World") ? "domeLight" : "distantLight"; }
  Value GetHostLightParameter(const Path& id, const Token& name) override {
    static const std::map<Token, Value> sun{{"intensity", 2.0f}, {"inputs:angle", 2.0f}, {"normalize", true}};
    static const std::map<Token, Value> world{{"inputs:color", Vec3f(0.2f, 0.4f, 0.6f)}};
    const auto& held = id == Path("/scene/World") ? world : sun;
    const auto found = held.find(name);
    return found == held.end() ? Value() : found->second;
  }
  hd::MaterialNetwork GetMaterialResource(const Path&) override {
    hd::MaterialNetwork network;
    network.nodes["/s"] = {"ND_standard_surface_surfaceshader",
                           {{"base", 1.0f}, {"base_color", Vec3f(0.6f, 0.3f, 0.2f)}, {"specular", 0.0f}},
                           {}};
    network.terminals["surface"] = {"/s", ""};
    return network;
  }
};

hd::CameraDescription camera() {
  hd::CameraDescription made;
  made.transform[3][2] = 4;
  made.parameters = {{"focalLength", 5.0f}, {"horizontalAperture", 3.6f}, {"verticalAperture", 3.6f}};
  return made;
}

hd::RenderPassState state_of(hd::RenderBuffer* buffer) {
  hd::RenderPassState state = hd::Stage::state_for(kSize, kSize, "color", buffer);
  state.camera = {};
  state.freeCamera = camera();
  return state;
}

class PollingHost : public ::testing::Test {
 protected:
  PollingHost() {
    for (const auto& [key, value] : std::map<Token, Value>{{"alabaster:samples", int64_t(16)}, {"threads", 2.0}}) {
      const Setting setting = TranslateSetting(key, value, stage_.delegate->GetRenderSettingDescriptors());
      stage_.delegate->SetRenderSetting(setting.key, setting.value);
    }
    buffer_ = static_cast<hd::RenderBuffer*>(stage_.delegate->CreateBprim("renderBuffer", "/buffer"));
    buffer_->Allocate({.dimensions = {kSize, kSize, 1}, .format = hd::Format::float32vec4});
    for (const auto& [type, id] : std::map<std::string, std::string>{
             {"material", "/scene/M_wax"}, {"distantLight", "/scene/O_sun"}, {"domeLight", "/scene/World"}})
      sprims_.push_back(stage_.delegate->CreateSprim(type, id));
    mesh_ = stage_.delegate->CreateRprim("mesh", "/scene/O_mesh");
  }
  ~PollingHost() override {
    driver_.reset();
    hd::RenderParam* const param = stage_.delegate->GetRenderParam();
    for (hd::Sprim* prim : sprims_) prim->Finalize(param), stage_.delegate->DestroySprim(prim);
    mesh_->Finalize(param), stage_.delegate->DestroyRprim(mesh_);
    buffer_->Finalize(param), stage_.delegate->DestroyBprim(buffer_);
  }

  void sync() {
    for (hd::Sprim* prim : sprims_) sync(prim);
    sync(mesh_);
    stage_.delegate->CommitResources();
  }
  void sync(hd::Prim* prim) {
    hd::DirtyBits bits = prim->GetInitialDirtyBitsMask();
    prim->Sync(&scene_, stage_.delegate->GetRenderParam(), &bits);
    EXPECT_EQ(bits, hd::dirty::kClean);
  }

  /// Executes once and polls. Empty if that takes more than 20 s.
  std::vector<float> picture() {
    driver_ = std::make_unique<PassDriver>(stage_.delegate->CreateRenderPass());
    sync();
    driver_->Execute(state_of(buffer_));
    const auto begun = std::chrono::steady_clock::now();
    double percent = 0;
    for (polls_ = 0;; ++polls_) {
      const hd::Dictionary statistics = HostStatistics(stage_.delegate->GetRenderStats());
      EXPECT_NE(statistics.at("percentDone").get<double>(), nullptr);
      EXPECT_GE(statistics.at("percentDone").number_or(-1) + 1e-9, percent) << "progress does not go back";
      percent = statistics.at("percentDone").number_or(-1);
      const bool converged = driver_->IsConverged();
      std::vector<float> pixels = mapped();
      if (converged) return pixels;
      if (std::chrono::steady_clock::now() - begun > std::chrono::seconds(20)) return {};
    }
  }
  std::vector<float> mapped() {
    const auto* const pixels = static_cast<const float*>(MapResolved(buffer_));
    std::vector<float> copied = pixels ? std::vector<float>(pixels, pixels + 4 * kSize * kSize) : std::vector<float>();
    buffer_->Unmap();
    return copied;
  }

  hd::Stage stage_;
  HostScene scene_;
  std::vector<hd::Sprim*> sprims_;
  hd::Rprim* mesh_ = nullptr;
  hd::RenderBuffer* buffer_ = nullptr;
  std::unique_ptr<PassDriver> driver_;
  int polls_ = 0;
};

std::vector<float> pixels_of(hd::RenderBuffer* buffer) {
  buffer->Resolve();
  const auto* const pixels = static_cast<const float*>(buffer->Map());
  std::vector<float> copied(pixels, pixels + 4 * kSize * kSize);
  buffer->Unmap();
  return copied;
}

/// The same data by our own terms, rendered by a host that executes until it has converged.
std::vector<float> expected_picture() {
  hd::Stage stage({{"samples", int64_t(16)}, {"threads", 2}});
  hd::host::MeshDescription mesh;
  mesh.topology.faceVertexCounts = {3, 3};
  mesh.topology.faceVertexIndices = {0, 1, 2, 0, 2, 3};
  mesh.primvars["points"].value = Array<Vec3f>{{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  mesh.primvars["normals"] = {
      hd::Interpolation::faceVarying, "normal", Array<Vec3f>(std::vector<Vec3f>(6, Vec3f(0, 0, 1))), {}};
  mesh.transform[3][0] = 0.25;
  mesh.material = "/m";
  stage.scene.SetMesh("/mesh", mesh);
  hd::MaterialNetwork network;
  network.nodes["/s"] = {
      "AlabasterDisney",
      {{"baseColor", Vec3f(0.6f, 0.3f, 0.2f)}, {"specular", 0.0f}, {"roughness", 0.2f}, {"diffuseRoughness", 0.43f}},
      {}};
  network.terminals["surface"] = {"/s", "out"};
  stage.scene.SetMaterial("/m", network);
  stage.scene.SetLight("/sun", {.type = "distantLight",
                                .transform = {},
                                .parameters = {{"intensity", 2.0f}, {"angle", 2.0f}, {"normalize", true}}});
  stage.scene.SetLight("/world", {.type = "domeLight",
                                  .transform = {},
                                  .parameters = {{"color", Vec3f(0.2f, 0.4f, 0.6f)}, {"visibleToCamera", true}}});
  hd::RenderBuffer* const buffer = stage.add_buffer("/color", kSize, kSize, hd::Format::float32vec4);
  stage.index->SyncAll();
  auto pass = stage.delegate->CreateRenderPass();
  EXPECT_TRUE(hd::Stage::finish(*pass, state_of(buffer)));
  pass.reset();
  return pixels_of(buffer);
}

TEST_F(PollingHost, GetsThePictureOfTheSameData) {
  const std::vector<float> pixels = picture();
  ASSERT_EQ(pixels.size(), size_t(4 * kSize * kSize)) << "converged, although it executes once";
  EXPECT_EQ(pixels, expected_picture());
  EXPECT_GT(pixels[4 * (kSize / 2 * kSize + kSize / 2)], 0.1f) << "the sun shines on the mesh";
  EXPECT_TRUE(stage_.take_diagnostics().empty());
}

std::vector<float> picture_of_file(const std::string& file) {
  hd::Stage stage({{"samples", int64_t(16)}, {"threads", 2}});
  const auto loaded = hd::description::LoadScene(
      file, &stage.scene, [](const hd::Diagnostic& d) { ADD_FAILURE() << d.where << ": " << d.text; });
  if (!loaded.ok) return {};
  hd::RenderBuffer* const buffer = stage.add_buffer("/color", kSize, kSize, hd::Format::float32vec4);
  stage.index->SyncAll();
  auto pass = stage.delegate->CreateRenderPass();
  hd::RenderPassState state = hd::Stage::state_for(kSize, kSize, "color", buffer);
  state.camera = stage.scene.GetRenderSettings(loaded.settings).camera;
  EXPECT_TRUE(hd::Stage::finish(*pass, state));
  pass.reset();
  return pixels_of(buffer);
}

class Folder {
 public:
  Folder() : path_(::testing::TempDir() + "captured_" + std::to_string(getpid())) {
    std::filesystem::create_directory(path_);
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  std::string file(const char* name) const { return path_ + "/" + name; }
  bool is_empty() const { return std::filesystem::is_empty(path_); }

 private:
  std::string path_;
};

// promise: pipeline.archive.hydra
TEST_F(PollingHost, WritesItsSceneAsFilesOfTheSamePicture) {
  SceneCapture capture;
  capture.TakeMesh(scene_, "/scene/O_mesh");
  capture.TakeMesh(scene_, "/scene/O_gone");
  capture.TakeMaterial(scene_, "/scene/M_wax");
  capture.TakeLight(scene_, "/scene/O_sun", "distantLight");
  capture.TakeLight(scene_, "/scene/World", "domeLight");
  capture.Remove("/scene/O_gone");
  const Folder folder;
  EXPECT_EQ(capture.Write(folder.file("held.alab"), state_of(buffer_), {{"samples", int64_t(16)}}), "");
  EXPECT_EQ(picture_of_file(folder.file("held.alab")), picture());
}

TEST(TranslatedScene, TheCameraSeesDomesUnlessTheHostSaysOtherwise) {
  HostScene seen, hidden(false);
  EXPECT_EQ(seen.GetLightParamValue("/scene/World", "visibleToCamera"), Value(true));
  EXPECT_EQ(hidden.GetLightParamValue("/scene/World", "visibleToCamera"), Value(false));
  EXPECT_TRUE(hidden.GetLightParamValue("/scene/O_sun", "visibleToCamera").empty());
}

TEST_F(PollingHost, WaitsBetweenPolls) {
  stage_.delegate->SetRenderSetting("samples", int64_t(1 << 20));
  stage_.delegate->SetRenderSetting("timeLimit", 0.5f);
  ASSERT_FALSE(picture().empty());
  EXPECT_LT(polls_, 200) << "each question of a tight loop waits for a moment";
}

TEST_F(PollingHost, FailedRenderConverges) {
  driver_ = std::make_unique<PassDriver>(stage_.delegate->CreateRenderPass());
  sync();
  hd::RenderPassState state = state_of(buffer_);
  state.freeCamera->transform = hd::Matrix4d(0.0);
  driver_->Execute(state);
  int questions = 0;
  while (!driver_->IsConverged() && questions < 500) ++questions;
  EXPECT_LT(questions, 500);
}

/// A pass that never ends and counts its executions.
class EndlessPass final : public hd::RenderPass {
 public:
  explicit EndlessPass(int* executed) : executed_(executed) {}
  void Execute(const hd::RenderPassState&) override { ++*executed_; }
  bool IsConverged() const override { return false; }
  hd::PassState GetState() const override { return hd::PassState::rendering; }
  bool WaitForConvergence(double) override { return false; }

 private:
  int* executed_;
};

TEST(PassDriver, RemovedBufferIsNotExecutedAgain) {
  hd::Stage stage;
  hd::RenderBuffer* const held = stage.add_buffer("/held", kSize, kSize, hd::Format::float32);
  hd::RenderBuffer* const other = stage.add_buffer("/other", kSize, kSize, hd::Format::float32);
  int executed = 0;
  PassDriver driver(std::make_unique<EndlessPass>(&executed));
  const auto ask_twice = [&] { return driver.IsConverged() || driver.IsConverged(); };
  driver.Execute(state_of(held));
  EXPECT_FALSE(ask_twice());
  EXPECT_EQ(executed, 2) << "once by the host, once by its second question";
  driver.Forget(other);
  driver.IsConverged();
  EXPECT_EQ(executed, 3);
  driver.Forget(held);
  ask_twice();
  EXPECT_EQ(executed, 3);
  driver.Execute(state_of(other));
  ask_twice();
  EXPECT_EQ(executed, 5);
}

TEST_F(PollingHost, BufferDestroyedBetweenPollsIsNotWritten) {
  driver_ = std::make_unique<PassDriver>(stage_.delegate->CreateRenderPass());
  sync();
  auto* const gone = static_cast<hd::RenderBuffer*>(stage_.delegate->CreateBprim("renderBuffer", "/gone"));
  gone->Allocate({.dimensions = {kSize, kSize, 1}, .format = hd::Format::float32vec4});
  driver_->Execute(state_of(gone));
  int questions = 0;
  while (!driver_->IsConverged() && questions < 500) ++questions;
  ASSERT_LT(questions, 500);
  driver_->Forget(gone);
  gone->Finalize(stage_.delegate->GetRenderParam());
  stage_.delegate->DestroyBprim(gone);
  sync();  // an edit: the pass is no longer converged
  for (int i = 0; i < 10; ++i) driver_->IsConverged();
  EXPECT_FALSE(picture().empty()) << "the pass renders again with another buffer";
}

TEST_F(PollingHost, HostThatExecutesBeforeEachPollIsNotDelayed) {
  driver_ = std::make_unique<PassDriver>(stage_.delegate->CreateRenderPass());
  stage_.delegate->SetRenderSetting("samples", int64_t(1 << 20));
  sync();
  stage_.wait_for_scene();
  const auto begun = std::chrono::steady_clock::now();
  for (int i = 0; i < 100; ++i) {
    driver_->Execute(state_of(buffer_));
    EXPECT_FALSE(driver_->IsConverged());
  }
  EXPECT_LT(std::chrono::steady_clock::now() - begun, std::chrono::milliseconds(1900))
      << "a hundred waits are two seconds at least";
}

}  // namespace
}  // namespace alabaster::hydra
