// Cameras by value, and what clips their rays.
#include <gtest/gtest.h>

#include <cmath>

#include "testenv/support/stage.h"

namespace alabaster::hd {
namespace {

constexpr int kSize = 24;

class FreeCamera : public ::testing::Test {
 protected:
  FreeCamera() {
    stage_.add_basic_scene();
    camera_ = stage_.scene.GetCameras().at("/camera");
    buffer_ = stage_.add_buffer("/color", kSize, kSize, Format::float32vec4);
    stage_.index->SyncAll();
    pass_ = stage_.delegate->CreateRenderPass();
    state_ = Stage::state_for(kSize, kSize, "color", buffer_);
  }
  ~FreeCamera() override { pass_.reset(); }

  std::vector<float> picture() {
    EXPECT_TRUE(Stage::finish(*pass_, state_));
    return Stage::pixels<float>(buffer_);
  }
  std::vector<float> picture_by_prim() {
    stage_.scene.SetCamera("/camera", camera_);
    stage_.index->SyncAll();
    state_.freeCamera.reset();
    return picture();
  }
  std::vector<float> picture_by_value() {
    state_.freeCamera = camera_;
    return picture();
  }
  double mean_alpha(const std::vector<float>& rgba) {
    double sum = 0;
    for (size_t i = 3; i < rgba.size(); i += 4) sum += double(rgba[i]);
    return sum / (kSize * kSize);
  }

  Stage stage_{{{"samples", int64_t(16)}, {"threads", 2}}};
  host::CameraDescription camera_;
  RenderBuffer* buffer_ = nullptr;
  std::unique_ptr<RenderPass> pass_;
  RenderPassState state_;
};

// promise: embedding.selection.camera
TEST_F(FreeCamera, GivesTheBytesOfThePrim) {
  camera_.parameters["fStop"] = 0.5f;
  camera_.parameters["focusDistance"] = 3.0f;
  camera_.transform[3][0] = 0.3;
  const auto expected = picture_by_prim();
  stage_.scene.Remove("/camera");
  stage_.index->SyncAll();
  EXPECT_EQ(picture_by_value(), expected) << "although no camera prim is left";
  camera_.parameters["fStop"] = 0.0f;
  EXPECT_NE(picture_by_value(), expected) << "without depth of field";
  EXPECT_TRUE(stage_.take_diagnostics().empty());
}

// Without a focus all is sharp, whatever the lens. A camera that moves on is not reported again.
TEST_F(FreeCamera, ALensWithoutAFocusIsReportedOnce) {
  camera_.parameters["fStop"] = 0.5f;
  const auto said = [this] {
    std::string text;
    for (const Diagnostic& d : stage_.take_diagnostics()) text += d.code + " " + d.where + ": " + d.text + "\n";
    return text;
  };
  picture_by_prim();
  const std::string once = said();
  EXPECT_EQ(once.find("camera.focus /camera: fStop has no effect while focusDistance is 0: set "), 0u) << once;
  EXPECT_EQ(once.find('\n'), once.size() - 1) << once;
  camera_.parameters["exposure"] = 1.0f;
  picture_by_prim();
  EXPECT_EQ(said(), "");
  picture_by_value();
  EXPECT_NE(said().find("camera.focus"), std::string::npos) << "another camera";
  camera_.transform[3][0] = 0.3;
  picture_by_value();
  EXPECT_EQ(said(), "");
  const auto samples = std::make_shared<TimeSamples<Value>>();
  *samples = {{0, 1}, {2.0f, 3.0f}};
  camera_.parameters["focusDistance:samples"] = std::shared_ptr<const TimeSamples<Value>>(samples);
  picture_by_value();
  EXPECT_EQ(said(), "") << "the focus moves";
  camera_.parameters.erase("focusDistance:samples");
  picture_by_value();
  EXPECT_NE(said().find("camera.focus"), std::string::npos);
  camera_.parameters["focusDistance"] = 3.0f;
  picture_by_value();
  EXPECT_EQ(said(), "");
  camera_.parameters["projection"] = Token("orthographic");
  picture_by_value();
  EXPECT_NE(said().find("an orthographic camera has no lens"), std::string::npos);
}

TEST_F(FreeCamera, ItsShutterNeedsNoSync) {
  host::MeshDescription mesh = Stage::quad();
  mesh.transformSamples = {{0, 1},
                           {Matrix4d().setTranslation(Vec3d(-0.5, 0, 0)), Matrix4d().setTranslation(Vec3d(0.5, 0, 0))}};
  stage_.scene.SetMesh("/quad", mesh);
  camera_.parameters["shutterOpen"] = 0.0;
  camera_.parameters["shutterClose"] = 1.0;
  const auto blurred = picture_by_prim();
  camera_.parameters["shutterClose"] = 0.0;
  const auto still = picture_by_prim();
  EXPECT_NE(blurred, still);
  camera_.parameters["shutterClose"] = 1.0;
  EXPECT_EQ(picture_by_value(), blurred);
  camera_.parameters["shutterClose"] = 0.0;
  EXPECT_EQ(picture_by_value(), still);
}

TEST_F(FreeCamera, MovesWithoutANewScene) {
  picture_by_value();
  const double number = stage_.stat("sceneNumber");
  camera_.transform[3][0] = 1;
  picture_by_value();
  EXPECT_EQ(stage_.stat("sceneNumber"), number);
}

TEST_F(FreeCamera, FaultsAreReportedOnce) {
  camera_.parameters["focalLength"] = -1.0f;
  camera_.parameters["clipPlanes"] = Array<Vec4f>{{0, 0, 0, 1}};
  picture_by_value();
  const auto diagnostics = stage_.take_diagnostics();
  ASSERT_EQ(diagnostics.size(), 2u);
  EXPECT_EQ(diagnostics[1].code, "camera.clipPlanes");
  EXPECT_EQ(diagnostics[0].where, "free camera");
  camera_.transform = Matrix4d().setScale(0.0);
  state_.freeCamera = camera_;
  EXPECT_TRUE(Stage::finish(*pass_, state_));
  EXPECT_EQ(pass_->GetState(), PassState::failed);
  EXPECT_EQ(stage_.count("pass.failed"), 1u);
}

// The quad stands 4 from the camera and covers a quarter of the picture, or half of it where it is cut in two.
TEST_F(FreeCamera, ClippingCutsWhatTheCameraSees) {
  const double whole = mean_alpha(picture_by_value());
  EXPECT_NEAR(whole, 0.25, 0.02);
  for (const Vec2f& range : {Vec2f(3.9f, 4.1f), Vec2f(0, 4.1f), Vec2f(3.9f, 0)}) {
    camera_.parameters["clippingRange"] = range;
    EXPECT_NEAR(mean_alpha(picture_by_value()), whole, 0.01) << range.x << " " << range.y;
  }
  for (const Vec2f& range : {Vec2f(4.1f, 100), Vec2f(0.1f, 3.9f)}) {
    camera_.parameters["clippingRange"] = range;
    EXPECT_EQ(mean_alpha(picture_by_value()), 0) << range.x << " " << range.y;
  }
  camera_.parameters.erase("clippingRange");
  camera_.parameters["clipPlanes"] = Array<Vec4f>{{1, 0, 0, 0}};  // keeps the half to the right
  const auto half = picture_by_value();
  EXPECT_NEAR(mean_alpha(half), whole / 2, 0.01);
  EXPECT_EQ(half[4 * (kSize / 2 * kSize + kSize / 2 - 3) + 3], 0);
  EXPECT_EQ(half[4 * (kSize / 2 * kSize + kSize / 2 + 3) + 3], 1);
  camera_.parameters["clipPlanes"] = Array<Vec4f>{{1, 0, 0, 0}, {0, -1, 0, 0}};
  EXPECT_NEAR(mean_alpha(picture_by_value()), whole / 4, 0.01);
  EXPECT_EQ(picture_by_prim(), picture_by_value());
}

// Only the camera's rays: the light on the quad is that of the whole scene, which a second quad shades.
TEST_F(FreeCamera, ClippingLeavesTheLightAlone) {
  host::MeshDescription roof = Stage::quad();
  roof.transform[3][2] = 0.5;
  stage_.scene.SetMesh("/roof", roof);
  stage_.index->SyncAll();
  camera_.parameters["clippingRange"] = Vec2f(3.75f, 0);
  const auto shaded = picture_by_value();
  stage_.scene.Remove("/roof");
  stage_.index->SyncAll();
  const auto bare = picture_by_value();
  const size_t middle = 4 * (kSize / 2 * kSize + kSize / 2);
  EXPECT_GT(shaded[middle], 0);
  EXPECT_LT(shaded[middle], 0.75f * bare[middle]);
  EXPECT_EQ(shaded[middle + 3], 1);
}

// A camera that stands in a body sees the same as one before it whose rays begin there.
TEST_F(FreeCamera, RaysThatBeginInABodyAreThoseOfACameraInIt) {
  host::MeshDescription body;
  body.topology.faceVertexCounts = {4, 4, 4, 4, 4, 4};
  body.topology.faceVertexIndices = {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5};
  std::vector<Vec3f> points;
  for (int i = 0; i < 8; ++i) points.emplace_back(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
  body.primvars["points"].value = Array<Vec3f>(std::move(points));
  body.material = "/wax";
  MaterialNetwork network;
  network.nodes["surface"].nodeTypeId = "AlabasterDisney";
  network.nodes["surface"].parameters["scatterDistance"] = Vec3f(0.4f);
  network.terminals["surface"] = {"surface", "surface"};
  stage_.scene.SetMaterial("/wax", network);
  stage_.scene.SetMesh("/quad", body);
  stage_.index->SyncAll();
  camera_.parameters["projection"] = Token("orthographic");
  camera_.transform[3][2] = 0.5;
  const auto within = picture_by_value();
  camera_.transform[3][2] = 4;
  EXPECT_NE(picture_by_value(), within) << "the skin, from before";
  for (const bool by_plane : {false, true}) {
    camera_.parameters.erase("clippingRange");
    if (by_plane)
      camera_.parameters["clipPlanes"] = Array<Vec4f>{{0, 0, -1, -3.5f}};
    else
      camera_.parameters["clippingRange"] = Vec2f(3.5f, 0);
    const auto cut = picture_by_value();
    double difference = 0, sum = 0;
    for (size_t i = 0; i < cut.size(); ++i) difference += double(cut[i] - within[i]), sum += double(within[i]);
    EXPECT_GT(sum, 0.1 * kSize * kSize);
    EXPECT_LT(std::abs(difference) / sum, 1e-3) << by_plane;
  }
}

}  // namespace
}  // namespace alabaster::hd
