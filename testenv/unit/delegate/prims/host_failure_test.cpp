// A host whose scene delegate throws: no exception crosses the contract, and a failed Sync is tried again.
#include <gtest/gtest.h>

#include <stdexcept>

#include "testenv/support/stage.h"

namespace alabaster::hd {
namespace {

/// Throws from one of a prim's calls, while `failing` names it.
class FailingScene final : public host::RetainedSceneDelegate {
 public:
  std::string failing;  // name of the call that throws; empty: none

  Matrix4d GetTransform(const Path& id) override {
    fail("GetTransform");
    return RetainedSceneDelegate::GetTransform(id);
  }
  bool GetVisible(const Path& id) override {
    fail("GetVisible");
    return RetainedSceneDelegate::GetVisible(id);
  }
  Path GetMaterialId(const Path& id) override {
    fail("GetMaterialId");
    return RetainedSceneDelegate::GetMaterialId(id);
  }
  Matrix4d GetInstancerTransform(const Path& id) override {
    fail("GetInstancerTransform");
    return RetainedSceneDelegate::GetInstancerTransform(id);
  }
  MaterialNetwork GetMaterialResource(const Path& id) override {
    fail("GetMaterialResource");
    return RetainedSceneDelegate::GetMaterialResource(id);
  }
  Value GetLightParamValue(const Path& id, const Token& name) override {
    fail("GetLightParamValue");
    return RetainedSceneDelegate::GetLightParamValue(id, name);
  }
  Value GetCameraParamValue(const Path& id, const Token& name) override {
    fail("GetCameraParamValue");
    return RetainedSceneDelegate::GetCameraParamValue(id, name);
  }
  RenderBufferDescriptor GetRenderBufferDescriptor(const Path& id) override {
    fail("GetRenderBufferDescriptor");
    return RetainedSceneDelegate::GetRenderBufferDescriptor(id);
  }
  RenderSettingsDescription GetRenderSettings(const Path& id) override {
    fail("GetRenderSettings");
    return RetainedSceneDelegate::GetRenderSettings(id);
  }

 private:
  void fail(const char* call) const {
    if (failing == call) throw std::runtime_error(std::string(call) + " threw");
  }
};

struct Failure {
  const char* call;
  const char* prim;
};

void add_a_prim_of_each_kind(host::RetainedSceneDelegate* scene) {
  scene->SetCamera("/camera", {.transform = {}, .parameters = {{"focalLength", 35.0f}}});
  scene->SetLight("/light", {.type = "rectLight", .transform = {}, .parameters = {{"intensity", 3.0f}}});
  scene->SetMaterial("/material", {});
  scene->SetInstancer("/instancer", {.transform = {},
                                     .parent = {},
                                     .primvars = {{"hydra:instanceTranslations", Array<Vec3f>{{1, 2, 3}}}},
                                     .indices = {{"/mesh", {0}}}});
  host::MeshDescription mesh = Stage::quad();
  mesh.material = "/material";
  mesh.instancer = "/instancer";
  scene->SetMesh("/mesh", mesh);
  scene->SetRenderBuffer("/buffer", {.dimensions = {4, 4, 1}, .format = Format::float32});
  scene->SetRenderSettings("/settings", {});
}

class HostFailure : public ::testing::TestWithParam<Failure> {};

// promise: embedding.errors
TEST_P(HostFailure, IsReportedAndTheSyncAfterItMakesGood) {
  Stage stage;
  FailingScene scene;
  add_a_prim_of_each_kind(&scene);
  scene.failing = GetParam().call;
  scene.Populate(stage.index.get());
  EXPECT_NO_THROW(stage.index->SyncAll());
  EXPECT_GE(stage.count("delegate.exception"), 1u);
  EXPECT_NE(stage.index->GetChangeTracker().Get(GetParam().prim), dirty::kClean) << "still to be done";
  scene.failing.clear();
  stage.take_diagnostics();
  const std::string mended = stage.dump();
  EXPECT_EQ(stage.count("delegate.exception"), 0u);
  EXPECT_EQ(stage.index->GetChangeTracker().Get(GetParam().prim), dirty::kClean);

  Stage untroubled;
  host::RetainedSceneDelegate same;
  add_a_prim_of_each_kind(&same);
  same.Populate(untroubled.index.get());
  EXPECT_EQ(mended, untroubled.dump());
  EXPECT_NE(mended.find("instance /mesh"), std::string::npos);
  same.Depopulate();
  scene.Depopulate();
}

INSTANTIATE_TEST_SUITE_P(
    EveryPull, HostFailure,
    ::testing::Values(Failure{"GetTransform", "/mesh"}, Failure{"GetVisible", "/mesh"},
                      Failure{"GetMaterialId", "/mesh"}, Failure{"GetInstancerTransform", "/instancer"},
                      Failure{"GetMaterialResource", "/material"}, Failure{"GetLightParamValue", "/light"},
                      Failure{"GetCameraParamValue", "/camera"}, Failure{"GetRenderBufferDescriptor", "/buffer"},
                      Failure{"GetRenderSettings", "/settings"}),
    [](const auto& info) { return std::string(info.param.call); });

TEST(HostFailure, ASinkThatThrowsIsNoTrouble) {
  DelegateOptions options;
  options.diagnostics = [](const Diagnostic&) { throw 7; };
  RenderDelegate* delegate = CreateAlabasterRenderDelegate(kAbiVersion, &options);
  ASSERT_NE(delegate, nullptr);
  EXPECT_NO_THROW(delegate->SetRenderSetting("samples", "many"));
  EXPECT_NO_THROW(delegate->CommitResources());
  DestroyAlabasterRenderDelegate(delegate);
}

}  // namespace
}  // namespace alabaster::hd
