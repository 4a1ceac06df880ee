// The archive of a captured scene holds what the scene delegate answered.
#include "delegate/hydra/scene_capture.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "delegate/archive/archive.h"
#include "testenv/support/stage.h"

namespace alabaster::hydra {
namespace {

using hd::Array;
using hd::Vec3f;

TEST(SceneCapture, HoldsEveryPrimThatWasTaken) {
  hd::Stage stage;
  hd::host::RetainedSceneDelegate& scene = stage.scene;
  hd::host::MeshDescription mesh = hd::Stage::quad();
  mesh.topology.orientation = "leftHanded";
  mesh.topology.geomSubsets = {{"/mesh/lid", "/m", {0}}};
  mesh.primvars["st"] = {
      hd::Interpolation::faceVarying, "textureCoordinate", Array<hd::Vec2f>{{0, 0}, {1, 0}}, {0, 1, 1, 0}};
  const hd::Value points = mesh.primvars["points"].value;
  mesh.primvarSamples["points"] = {{0, 1}, {points, points}};
  mesh.transformSamples = {{0, 1}, {hd::Matrix4d(), hd::Matrix4d().setTranslation(hd::Vec3d(1, 0, 0))}};
  mesh.cullStyle = hd::CullStyle::front, mesh.doubleSided = false, mesh.renderTag = "proxy";
  mesh.categories = {"some"}, mesh.material = "/m", mesh.instancer = "/many";
  scene.SetMesh("/mesh", mesh);
  hd::host::InstancerDescription many;
  many.primvars["hydra:instanceTranslations"] = Array<Vec3f>{{0, 0, 0}, {1, 0, 0}};
  many.indices["/mesh"] = {1, 0};
  many.categories = {{}, {"some"}};
  many.transformSamples = mesh.transformSamples;
  scene.SetInstancer("/many", many);
  hd::MaterialNetwork network;
  network.nodes["/m/s"] = {"ND_unlit_surface", {{"roughness", 0.25f}}, {{"sheen", {{"/m/gone", "r"}}}}};
  network.nodes["/elsewhere"] = {"UsdUVTexture", {{"file", hd::AssetPath{"a.png", "/gone/a.png", nullptr}}}, {}};
  network.terminals["surface"] = {"/m/s", "surface"};
  network.terminals["volume"] = {"/elsewhere", "out"};
  scene.SetMaterial("/m", network);
  hd::host::LightDescription sun{.type = "distantLight", .transform = {}, .parameters = {{"angle", 2.0f}}};
  sun.parameters["lightLink"] = hd::Token("some");
  scene.SetLight("/sun", sun);

  SceneCapture capture;
  capture.TakeMesh(scene, "/mesh"), capture.TakeInstancer(scene, "/many");
  capture.TakeMaterial(scene, "/m"), capture.TakeLight(scene, "/sun", "distantLight");
  capture.TakeMesh(scene, "/gone"), capture.Remove("/gone");
  hd::RenderPassState state;
  state.freeCamera = hd::CameraDescription{};
  state.framing.dataWindow = {0, 0, 8, 8};
  const std::string file = ::testing::TempDir() + "capture_" + std::to_string(getpid()) + ".alab";
  ASSERT_EQ(capture.Write(file, state, {{"samples", int64_t(16)}}), "");

  hd::host::RetainedSceneDelegate read;
  EXPECT_TRUE(hd::archive::ReadArchive(file, &read, {}, {.allow_outside = true}).ok);
  std::filesystem::remove(file);
  EXPECT_EQ(read.GetMeshes(), scene.GetMeshes());
  EXPECT_EQ(read.GetInstancers(), scene.GetInstancers());
  EXPECT_EQ(read.GetMaterials(), scene.GetMaterials());
  EXPECT_EQ(read.GetLights(), scene.GetLights());
  const auto settings = read.GetAllRenderSettings().at("/render");
  EXPECT_EQ(settings.width, 8);
  EXPECT_EQ(settings.settings, (hd::Dictionary{{"samples", int64_t(16)}}));
}

TEST(SceneCapture, SaysWhyItIsNotWritten) {
  hd::RenderPassState state;
  state.freeCamera = hd::CameraDescription{};
  state.framing.dataWindow = {0, 0, 8, 8};
  EXPECT_NE(SceneCapture().Write("held.txt", state, {}).find("must end in .alab"), std::string::npos);
  EXPECT_NE(SceneCapture().Write("/gone/held.alab", state, {}).find("/gone"), std::string::npos);
}

}  // namespace
}  // namespace alabaster::hydra
