// AOVs of vectors at the first hit: Peye, Neye, position, uv, motion and primvars by name; and cameraDistance.
#include <gtest/gtest.h>

#include <cmath>

#include "testenv/support/stage.h"

namespace alabaster::hd {
namespace {

constexpr int kSide = 8;

class HitVectorAovs : public ::testing::Test {
 protected:
  HitVectorAovs() {
    stage.add_basic_scene();
    pass = stage.delegate->CreateRenderPass();
  }
  ~HitVectorAovs() override { pass.reset(); }

  // Rows from the top.
  std::vector<float> picture(const char* aov, size_t components) {
    const Format format = components == 2 ? Format::float32vec2 : Format::float32vec3;
    const std::string path = "/buffer_" + std::to_string(components);
    auto* buffer = static_cast<RenderBuffer*>(stage.index->GetBprim(path));
    if (!buffer) buffer = stage.add_buffer(path.c_str(), kSide, kSide, format);
    stage.index->SyncAll();
    EXPECT_TRUE(Stage::finish(*pass, Stage::state_for(kSide, kSide, aov, buffer)));
    return Stage::pixels<float>(buffer);
  }
  static std::vector<float> at(const std::vector<float>& picture, int x, int y, size_t components) {
    const auto first = picture.begin() + std::ptrdiff_t(components) * (y * kSide + x);
    return {first, first + std::ptrdiff_t(components)};
  }
  void move_camera(Matrix4d transform, const TimeSamples<Matrix4d>& samples = {}) {
    host::CameraDescription camera = stage.scene.GetCameras().at("/camera");
    camera.transform = transform;
    camera.transformSamples = samples;
    stage.scene.SetCamera("/camera", camera);
  }
  void open_shutter() {
    host::CameraDescription camera = stage.scene.GetCameras().at("/camera");
    camera.parameters["shutterOpen"] = 0.0f;
    camera.parameters["shutterClose"] = 1.0f;
    stage.scene.SetCamera("/camera", camera);
  }
  static Matrix4d moved(double x, double y, double z) {
    Matrix4d m;
    m.setTranslation(Vec3d(x, y, z));
    return m;
  }

  Stage stage{{{"samples", int64_t(4)}, {"filter", std::string("box")}}};
  std::unique_ptr<RenderPass> pass;
};

// promise: pipeline.aov.eye
TEST_F(HitVectorAovs, PlaceAndNormalAreThoseThatTheCameraSees) {
  const auto seen = [&] {
    const auto p = picture("Peye", 3), n = picture("Neye", 3);
    // The picture is 4 units wide: pixel 5, 2 is x 0.5..1, y 0.5..1.
    const auto place = at(p, 5, 2, 3), normal = at(n, 5, 2, 3);
    EXPECT_NEAR(place[0], 0.75f, 0.25f);
    EXPECT_NEAR(place[1], 0.75f, 0.25f);
    EXPECT_NEAR(place[2], -4, 1e-5f);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(normal[size_t(i)], i == 2 ? 1 : 0, 1e-6f);
    EXPECT_EQ(at(p, 0, 0, 3), (std::vector<float>{0, 0, 0})) << "nothing is there";
  };
  seen();
  // Camera and quad, turned together.
  Matrix4d turn;
  turn.setAxisAngle(Vec3d(0, 1, 0), 0.7);
  host::MeshDescription quad = Stage::quad();
  quad.transform = turn;
  stage.scene.SetMesh("/quad", quad);
  move_camera(moved(0, 0, 4) * turn);
  seen();
}

// promise: pipeline.aov.position
TEST_F(HitVectorAovs, PositionIsInTheWorld) {
  Matrix4d turn;
  turn.setAxisAngle(Vec3d(0, 1, 0), 0.7);
  const Matrix4d place = turn * moved(300, -20, 1000);
  host::MeshDescription quad = Stage::quad();
  quad.transform = place;
  stage.scene.SetMesh("/quad", quad);
  move_camera(moved(0, 0, 4) * place);
  const auto p = picture("position", 3), eye = picture("Peye", 3);
  // In the camera's frame the quad lies at z = -4.
  for (const int x : {2, 5}) {
    const auto seen = at(eye, x, 3, 3), world = at(p, x, 3, 3);
    const Vec3d expected = Vec3d(seen[0], seen[1], seen[2] + 4) * place;
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(world[size_t(i)], float(expected[i]), 1e-3f) << x;
  }
  EXPECT_EQ(at(p, 0, 0, 3), (std::vector<float>{0, 0, 0})) << "nothing is there";
}

// promise: pipeline.aov.distances
TEST_F(HitVectorAovs, DistanceIsThatFromTheCamerasPlace) {
  const auto eye = picture("Peye", 3);
  auto* buffer = stage.add_buffer("/distance", kSide, kSide, Format::float32);
  const auto distance = [&](const char* aov) {
    stage.index->SyncAll();
    EXPECT_TRUE(Stage::finish(*pass, Stage::state_for(kSide, kSide, aov, buffer)));
    return Stage::pixels<float>(buffer);
  };
  const auto straight = distance("cameraDistance"), axial = distance("cameraDepth");
  for (const int x : {2, 3, 5}) {
    const auto p = at(eye, x, 2, 3);
    const auto i = size_t(2 * kSide + x);
    EXPECT_FLOAT_EQ(straight[i], std::hypot(p[0], p[1], p[2]));
    EXPECT_FLOAT_EQ(axial[i], -p[2]);
  }
  EXPECT_EQ(straight[0], 0) << "nothing is there";
  host::CameraDescription camera = stage.scene.GetCameras().at("/camera");
  camera.parameters["projection"] = std::string("orthographic");
  camera.parameters["horizontalAperture"] = camera.parameters["verticalAperture"] = 4.0f;
  stage.scene.SetCamera("/camera", camera);
  EXPECT_FLOAT_EQ(distance("cameraDistance")[2 * kSide + 2], 4) << "along its axis";
}

// promise: pipeline.aov.uv
TEST_F(HitVectorAovs, UvIsSt) {
  host::MeshDescription quad = Stage::quad();
  EXPECT_EQ(picture("uv", 2), std::vector<float>(2 * kSide * kSide, 0.0f)) << "it has none";
  // Coordinates of other names do not take its place, whatever the order of names is.
  const auto set = [&](const char* name, float low, float high) {
    quad.primvars[name] = {Interpolation::vertex,
                           "textureCoordinate",
                           Array<Vec2f>{{low, low}, {high, low}, {high, high}, {low, high}},
                           {}};
  };
  set("a", 5, 7);
  stage.scene.SetMesh("/quad", quad);
  EXPECT_NEAR(at(picture("uv", 2), 4, 4, 2)[0], 6.25f, 0.25f) << "the first set";
  set("st", 0, 1);
  stage.scene.SetMesh("/quad", quad);
  const auto eye = picture("Peye", 3), uv = picture("uv", 2);
  for (const int x : {2, 5})
    for (const int y : {3, 5}) {
      const auto p = at(eye, x, y, 3), st = at(uv, x, y, 2);
      EXPECT_NEAR(st[0], (p[0] + 1) / 2, 1e-5f);
      EXPECT_NEAR(st[1], (p[1] + 1) / 2, 1e-5f) << "it grows upwards";
    }
}

// promise: pipeline.aov.motion, pipeline.aov.motion_movers
TEST_F(HitVectorAovs, MotionIsUpToTheNextFrameAlsoWithAClosedShutter) {
  auto* color = stage.add_buffer("/color", kSide, kSide, Format::float32vec4);
  const auto colors = [&] {
    stage.index->SyncAll();
    EXPECT_TRUE(Stage::finish(*pass, Stage::state_for(kSide, kSide, "color", color)));
    return Stage::pixels<float>(color);
  };
  const auto seen = [&](const char* what, float x, float y) {
    const auto before = colors();
    const auto motion = picture("motion", 2);
    const auto middle = at(motion, 4, 4, 2);
    EXPECT_NEAR(middle[0], x, 1e-4f) << what;
    EXPECT_NEAR(middle[1], y, 1e-4f) << what;
    EXPECT_EQ(at(motion, 0, 0, 2), (std::vector<float>{0, 0})) << "nothing is there";
    EXPECT_EQ(colors(), before) << what;
  };
  // Two pixels are a unit. What comes before this frame and after the next one does not count.
  const TimeSamples<Matrix4d> path{{-1, 0, 1, 2},
                                   {moved(9, 9, 0), moved(0, 0, 0), moved(0.25, 0.5, 0), moved(9, 9, 0)}};
  host::MeshDescription quad = Stage::quad();
  quad.transformSamples = path;
  stage.scene.SetMesh("/quad", quad);
  seen("a transform", 0.5f, 1);
  host::InstancerDescription instancer;
  instancer.indices["/quad"] = {0};
  quad.instancer = "/instancer";
  stage.scene.SetInstancer("/instancer", instancer);
  stage.scene.SetMesh("/quad", quad);
  seen("a transform of an instance", 0.5f, 1);
  instancer.transformSamples = path;
  stage.scene.SetInstancer("/instancer", instancer);
  seen("both", 1, 2);
  quad.transformSamples = {};
  stage.scene.SetMesh("/quad", quad);
  seen("an instancer", 0.5f, 1);
  quad.instancer = {};
  const auto points = [](float x) {
    return Array<Vec3f>{{-1 + x, -1, 0}, {1 + x, -1, 0}, {1 + x, 1, 0}, {-1 + x, 1, 0}};
  };
  quad.primvarSamples["points"] = {{-1, 0, 1}, {points(9), points(0), points(0.25f)}};
  stage.scene.SetMesh("/quad", quad);
  seen("points", 0.5f, 0);
  instancer.transformSamples = {};
  quad.instancer = "/instancer";
  stage.scene.SetInstancer("/instancer", instancer);
  stage.scene.SetMesh("/quad", quad);
  seen("points of an instance", 0.5f, 0);
  quad.instancer = {};
  quad.primvarSamples = {};
  stage.scene.SetMesh("/quad", quad);
  move_camera(moved(0, 0, 4), {{0, 1}, {moved(0, 0, 4), moved(0.25, 0.5, 4)}});
  seen("the camera", -0.5f, -1);
  stage.delegate->SetRenderSetting("motionShutter", std::string("camera"));
  EXPECT_EQ(picture("motion", 2), std::vector<float>(2 * kSide * kSide, 0.0f)) << "its shutter is closed";
}

// An open shutter blurs what it sees, each sample at its time: the motion is that of the whole frame, of each point.
// promise: pipeline.aov.motion_blurred
TEST_F(HitVectorAovs, MotionOfWhatIsBlurredIsUpToTheNextFrame) {
  host::MeshDescription quad = Stage::quad();
  quad.transformSamples = {{-0.5, 0, 0.5, 1}, {moved(-0.5, 0, 0), moved(0, 0, 0), moved(0.1, 0, 0), moved(0.25, 0, 0)}};
  stage.scene.SetMesh("/quad", quad);
  host::CameraDescription camera = stage.scene.GetCameras().at("/camera");
  camera.parameters["shutterOpen"] = -0.5f;
  camera.parameters["shutterClose"] = 0.5f;
  stage.scene.SetCamera("/camera", camera);
  EXPECT_NEAR(at(picture("motion", 2), 4, 4, 2)[0], 0.5f, 1e-4f);
  stage.delegate->SetRenderSetting("motionShutter", std::string("camera"));
  EXPECT_NEAR(at(picture("motion", 2), 4, 4, 2)[0], 1.2f, 1e-4f);
}

// promise: pipeline.aov.motion_ends
TEST_F(HitVectorAovs, MotionEndsWhereSamplesEnd) {
  host::MeshDescription quad = Stage::quad();
  quad.transformSamples = {{-0.25, 0.25}, {moved(-0.1, 0, 0), moved(0.1, 0, 0)}};
  stage.scene.SetMesh("/quad", quad);
  EXPECT_NEAR(at(picture("motion", 2), 4, 4, 2)[0], 0.2f, 1e-4f);
}

// promise: pipeline.aov.motion_shutter
TEST_F(HitVectorAovs, MotionIsInPixelsWhileTheShutterIsOpen) {
  stage.delegate->SetRenderSetting("motionShutter", std::string("camera"));
  EXPECT_EQ(picture("motion", 2), std::vector<float>(2 * kSide * kSide, 0.0f)) << "a closed shutter";
  host::MeshDescription quad = Stage::quad();
  quad.transformSamples = {{0, 1}, {moved(0, 0, 0), moved(0.25, 0.5, 0)}};
  stage.scene.SetMesh("/quad", quad);
  open_shutter();
  const auto by_mesh = at(picture("motion", 2), 4, 4, 2);  // two pixels are a unit; y up
  EXPECT_NEAR(by_mesh[0], 0.5f, 1e-4f);
  EXPECT_NEAR(by_mesh[1], 1, 1e-4f);
  quad.transformSamples = {};
  stage.scene.SetMesh("/quad", quad);
  move_camera(moved(0, 0, 4), {{0, 1}, {moved(0, 0, 4), moved(0.25, 0.5, 4)}});
  const auto by_camera = at(picture("motion", 2), 4, 4, 2);
  EXPECT_NEAR(by_camera[0], -0.5f, 1e-4f);
  EXPECT_NEAR(by_camera[1], -1, 1e-4f);
  // Both together: nothing moves in the picture.
  quad.transformSamples = {{0, 1}, {moved(0, 0, 0), moved(0.25, 0.5, 0)}};
  stage.scene.SetMesh("/quad", quad);
  EXPECT_NEAR(at(picture("motion", 2), 4, 4, 2)[0], 0, 1e-4f);
}

TEST_F(HitVectorAovs, MotionOfWhatDeforms) {
  host::MeshDescription quad = Stage::quad();
  const Array<Vec3f> start = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  const Array<Vec3f> end = {{-2, -1, 0}, {2, -1, 0}, {2, 1, 0}, {-2, 1, 0}};
  quad.primvarSamples["points"] = {{0, 1}, {start, end}};
  stage.scene.SetMesh("/quad", quad);
  open_shutter();
  const auto motion = picture("motion", 2);
  EXPECT_GT(at(motion, 5, 4, 2)[0], 0.1f);
  EXPECT_LT(at(motion, 2, 4, 2)[0], -0.1f);
  EXPECT_NEAR(at(motion, 5, 4, 2)[1], 0, 1e-4f);
}

// promise: pipeline.aov.primvars
TEST_F(HitVectorAovs, PrimvarsAreFoundByTheirNames) {
  host::MeshDescription quad = Stage::quad();
  const std::pair<const char*, Value> values[] = {{"mask", Array<float>{1, 1, 1, 1}},
                                                  {"flow", Array<Vec2f>(std::vector<Vec2f>(4, {2, 3}))},
                                                  {"rest", Array<Vec3f>(std::vector<Vec3f>(4, {4, 5, 6}))},
                                                  {"tint", Array<Vec4f>(std::vector<Vec4f>(4, {7, 8, 9, 10}))},
                                                  {"count", Array<int32_t>{11, 11, 11, 11}}};
  for (const auto& [name, value] : values) quad.primvars[name].value = value;
  quad.primvars["label"] = {Interpolation::constant, {}, std::string("a text"), {}};
  stage.scene.SetMesh("/quad", quad);
  stage.scene.SetMesh("/other", [] {
    host::MeshDescription other = Stage::quad();
    other.transform = moved(10, 0, 0);
    return other;
  }());
  const auto middle = [&](const char* name) { return at(picture(name, 3), 4, 4, 3); };
  EXPECT_EQ(middle("primvars:mask"), (std::vector<float>{1, 0, 0}));
  EXPECT_EQ(middle("primvars:flow"), (std::vector<float>{2, 3, 0}));
  EXPECT_EQ(middle("primvars:rest"), (std::vector<float>{4, 5, 6}));
  EXPECT_EQ(middle("primvars:tint"), (std::vector<float>{7, 8, 9}));
  EXPECT_EQ(middle("primvars:count"), (std::vector<float>{11, 0, 0}));
  EXPECT_EQ(middle("primvars:label"), (std::vector<float>{0, 0, 0})) << "a text";
  EXPECT_EQ(middle("primvars:none"), (std::vector<float>{0, 0, 0}));
  const auto points = middle("primvars:points");
  EXPECT_NEAR(points[0], 0.25f, 0.25f);
  // An edit of one that no material reads shows.
  quad.primvars["mask"].value = Array<float>{3, 3, 3, 3};
  stage.scene.SetMesh("/quad", quad);
  EXPECT_EQ(middle("primvars:mask"), (std::vector<float>{3, 0, 0}));
}

// One that no AOV shows costs nothing: the mesh is not built again.
TEST_F(HitVectorAovs, OtherPrimvarsBuildNothingUntilTheyAreShown) {
  host::MeshDescription quad = Stage::quad();
  stage.scene.SetMesh("/quad", quad);
  picture("Peye", 3);
  const double built = stage.stat("sync.bvhSeconds"), number = stage.stat("sceneNumber");
  quad.primvars["mask"].value = Array<float>{1, 1, 1, 1};
  stage.scene.SetMesh("/quad", quad);
  picture("Peye", 3);
  EXPECT_EQ(stage.stat("sync.bvhSeconds"), built);
  EXPECT_EQ(stage.stat("sceneNumber"), number) << "the picture goes on";
}

// promise: pipeline.aov.eight_primvars
TEST_F(HitVectorAovs, SeveralAtOnceAndOneTooMany) {
  host::MeshDescription quad = Stage::quad();
  RenderPassState state =
      Stage::state_for(kSide, kSide, "color", stage.add_buffer("/c", kSide, kSide, Format::float32vec4));
  std::vector<RenderBuffer*> buffers;
  for (int i = 0; i < 9; ++i) {
    const std::string name = "p" + std::to_string(i);
    quad.primvars[name] = {Interpolation::constant, {}, float(i + 1), {}};
    buffers.push_back(stage.add_buffer(("/" + name).c_str(), kSide, kSide, Format::float32vec3));
    state.aovBindings.push_back({"primvars:" + name, buffers.back(), {}});
  }
  stage.scene.SetMesh("/quad", quad);
  stage.index->SyncAll();
  EXPECT_TRUE(Stage::finish(*pass, state));
  for (size_t i = 0; i < 8; ++i) EXPECT_EQ(at(Stage::pixels<float>(buffers[i]), 4, 4, 3)[0], float(i + 1)) << i;
  EXPECT_EQ(stage.count("pass.binding"), 1u);
}

}  // namespace
}  // namespace alabaster::hd
