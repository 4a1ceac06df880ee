// Scenes of a host's own, written and read again.
#include <limits>

#include "testenv/unit/delegate/description/write_scene_fixture.h"

namespace alabaster::hd::description {
namespace {

using nlohmann::json;

MaterialNetwork plain(std::map<Token, Value> parameters) {
  MaterialNetwork network;
  network.nodes["/s"] = {"AlabasterDisney", std::move(parameters), {}};
  network.terminals["surface"] = {"/s", "surface"};
  return network;
}

class WrittenScene : public WriteSceneTest {
 protected:
  WrittenScene() { stage_.add_basic_scene(); }
  host::RetainedSceneDelegate& scene() { return stage_.scene; }
  /// A small quad that is turned away from the camera a little.
  void add_quad(const Path& id, double x, double y, const Path& material) {
    host::MeshDescription mesh = Stage::quad();
    mesh.transform = Matrix4d(0.3, 0, 0.1, 0, 0, 0.3, 0, 0, -0.1, 0, 0.3, 0, x, y, 0.5, 1);
    mesh.material = material;
    scene().SetMesh(id, mesh);
  }
};

TEST_F(WrittenScene, HoldsMeshesWithoutAMaterial) {
  add_quad("/red", 1, 0, {});
  host::MeshDescription red = scene().GetMeshes().at("/red");
  red.primvars["displayColor"] = {Interpolation::constant, "color", Array<Vec3f>{{1, 0.1f, 0.3f}}, {}};
  scene().SetMesh("/red_and_opaque", red);
  red.primvars["displayOpacity"] = {Interpolation::constant, "", 0.5f, {}};
  scene().SetMesh("/red", red);
  host::MeshDescription colors = Stage::quad();
  colors.primvars["displayColor"] = {
      Interpolation::vertex, "color", Array<Vec3f>{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}}, {}};
  scene().SetMesh("/colors", colors);
  add_quad("/lost", -1, 0, "/no/such/material");
  expect_same_picture();
  EXPECT_EQ(document("copy.gltf")["materials"].size(), 3u);
}

// Lights and emissive meshes are sampled in the order of their names.
TEST_F(WrittenScene, KeepsTheOrderOfMeshesAndLightsWhateverTheirNames) {
  scene().SetMaterial("/lamp", plain({{"emission", Vec3f(3, 2, 1)}}));
  scene().SetMaterial("/m*", plain({{"baseColor", Vec3f(0.9f, 0.4f, 0.1f)}}));
  scene().SetMaterial("/m", plain({{"baseColor", Vec3f(0.1f, 0.4f, 0.9f)}}));
  const char* const names[] = {"/a/b", "/a_b", "/1",        "/2_x", "/x",  "/[x]",
                               "/a b", "/m*n", "/\xc3\xa4", "/B",   "/10", "/Z/z"};
  double x = -2;
  for (const char* name : names) {
    x += 0.3;
    add_quad(name, x, 0.2 * x, x < 0 ? "/lamp" : x < 1 ? "/m*" : "/m");
    scene().SetLight(std::string("/lights") + name, {.type = "sphereLight",
                                                     .transform = Matrix4d().setTranslation(Vec3d(-x, 1, 2)),
                                                     .parameters = {{"intensity", float(3 + x)}, {"radius", 0.1f}}});
  }
  expect_same_picture();
}

TEST_F(WrittenScene, HoldsInstancersInInstancers) {
  host::MeshDescription quad = Stage::quad();
  quad.transform = Matrix4d().setScale(Vec3d(0.2, 0.3, 0.2));
  quad.instancer = "/inner";
  scene().SetMesh("/quad", quad);
  host::InstancerDescription inner;
  inner.transform = Matrix4d().setTranslation(Vec3d(0.1, 0.2, 0.3));
  inner.parent = "/outer";
  inner.primvars["hydra:instanceTranslations"] = Array<Vec3f>{{-0.5f, 0, 0}, {0.5f, 0, 0}, {9, 9, 9}};
  inner.primvars["hydra:instanceRotations"] = Array<Quatf>{{0.9f, 0.1f, 0.2f, 0.3f}, {1, 0, 0, 0.5f}};
  inner.primvars["hydra:instanceScales"] = Array<Vec3f>{{1, 2, 1}};
  inner.indices["/quad"] = {1, 0, 7};
  scene().SetInstancer("/inner", inner);
  host::InstancerDescription outer;
  outer.primvars["hydra:instanceTransforms"] =
      Array<Matrix4d>{Matrix4d(1, 0.2, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0.7, 0, 1),
                      Matrix4d(1, 0, 0, 0, 0.1, 1, 0, 0, 0, 0, 1, 0, 0, -0.7, 0.1, 1)};
  outer.indices["/inner"] = {0, 1};
  scene().SetInstancer("/outer", outer);
  expect_same_picture();
  EXPECT_EQ(document("copy.gltf")["meshes"].size(), 1u) << "the instances share it";
  EXPECT_EQ(document("copy.gltf")["nodes"].size(), 4u) << "index 7 names no place";
}

TEST_F(WrittenScene, HoldsManyInstancesAsArrays) {
  host::MeshDescription quad = Stage::quad();
  quad.instancer = "/inner";
  scene().SetMesh("/quad", quad);
  std::vector<Vec3f> places, scales;
  std::vector<Quatf> turns;
  std::vector<int32_t> indices;
  for (int32_t i = 0; i < 100; ++i) {
    const float t = float(i);
    places.emplace_back(1.5f * std::sin(t), std::cos(1.7f * t), 0.01f * t);
    turns.emplace_back(0.3f + std::sin(t), 0.1f, 0.2f, std::cos(t));
    if (i < 90) scales.emplace_back(0.05f, 0.07f, 0.1f);
    indices.push_back(i == 50 ? 1000 : 99 - i);
  }
  turns[7] = Quatf(0, 0, 0, 0);
  places[20].x = std::numeric_limits<float>::quiet_NaN();
  scales[30].y = 0;
  host::InstancerDescription inner;
  inner.transform = Matrix4d().setTranslation(Vec3d(0.1, 0.2, 0.3));
  inner.parent = "/outer";
  inner.primvars = {{"hydra:instanceTranslations", Array<Vec3f>(places)},
                    {"hydra:instanceRotations", Array<Quatf>(turns)},
                    {"hydra:instanceScales", Array<Vec3f>(scales)}};
  inner.indices["/quad"] = indices;
  scene().SetInstancer("/inner", inner);
  host::InstancerDescription outer;
  outer.primvars["hydra:instanceRotations"] = Array<Quatf>{{0.9f, 0.1f, 0.2f, 0.3f}, {1, 0, 0, 0.5f}};
  outer.indices["/inner"] = {0, 1};
  scene().SetInstancer("/outer", outer);
  expect_same_picture();
  EXPECT_EQ(document("copy.gltf")["nodes"].size(), 2u);
}

TEST_F(WrittenScene, LeavesOutWhatIsNotDrawn) {
  add_quad("/hidden", 1, 0, {});
  host::MeshDescription hidden = scene().GetMeshes().at("/hidden");
  hidden.visible = false;
  hidden.topology.orientation = "leftHanded";  // would be refused
  scene().SetMesh("/hidden", hidden);
  hidden.visible = true, hidden.renderTag = "proxy";
  scene().SetMesh("/proxy", hidden);
  hidden.renderTag = "geometry";
  scene().SetMesh("/group/excluded", hidden);
  hidden.instancer = "/nowhere";
  scene().SetMesh("/lost", hidden);
  scene().SetInstancer("/none", {});
  hidden.instancer = "/none";
  scene().SetMesh("/not_placed", hidden);
  scene().SetLight("/off", {.type = "distantLight", .transform = {}, .parameters = {}, .visible = false});
  scene().SetLight("/flat", {.type = "rectLight", .transform = Matrix4d().setScale(Vec3d(1, 0, 1)), .parameters = {}});
  hidden = Stage::quad();
  hidden.transform[3][0] = std::numeric_limits<double>::quiet_NaN();
  scene().SetMesh("/nowhere_at_all", hidden);
  state_.collection.excludePaths = {"/group"};
  expect_same_picture();
  EXPECT_EQ(document("copy.gltf")["meshes"].size(), 1u);
  EXPECT_EQ(document()["lights"].size(), 1u);
}

TEST_F(WrittenScene, HoldsWhatTheCameraSeesAndBodies) {
  scene().SetMaterial("/wax", plain({{"baseColor", Vec3f(0.8f, 0.5f, 0.3f)}, {"scatterDistance", Vec3f(0.5f)}}));
  const std::pair<const char*, Value> flags[] = {
      {"holdout", true}, {"visibleToCamera", false}, {"subsurfaceSet", Token("set")}};
  double x = -1.5;
  for (const auto& [name, value] : flags) {
    const Path id = Path("/").append(name);
    add_quad(id, x += 0.8, 0.3, "/wax");
    host::MeshDescription mesh = scene().GetMeshes().at(id);
    mesh.primvars[name] = {Interpolation::constant, "", value, {}};
    scene().SetMesh(id, mesh);
  }
  expect_same_picture();
  EXPECT_EQ(document()["meshes"].size(), 3u);
}

TEST_F(WrittenScene, HoldsLinksOfLights) {
  add_quad("/lit", 0.6, 0.3, {});
  add_quad("/other", -0.6, 0.3, {});
  host::MeshDescription lit = scene().GetMeshes().at("/lit");
  lit.categories = {"a", "b"};
  scene().SetMesh("/lit", lit);
  scene().SetLight("/key",
                   {.type = "distantLight",
                    .transform = {},
                    .parameters = {{"lightLink", Token("a")}, {"shadowLink", Token("b")}, {"intensity", 2.0f}}});
  scene().SetLight("/nobody", {.type = "distantLight", .transform = {}, .parameters = {{"lightLink", Token("c")}}});
  expect_same_picture();
  EXPECT_EQ(document()["lights"][1]["lightLink"], json({"_lit"}));
}

// The reader adds a light to scenes that have none.
TEST_F(WrittenScene, StaysDarkWithoutLight) {
  scene().Remove("/dome");
  ASSERT_EQ(write(), "");
  EXPECT_EQ(picture(), picture_of(file()));
  scene().SetMaterial("/lamp", plain({{"emission", Vec3f(3, 2, 1)}}));
  add_quad("/lamp_quad", 0.5, 0.5, "/lamp");
  expect_same_picture();
  EXPECT_FALSE(document().contains("lights"));
}

TEST_F(WrittenScene, HoldsTheCameraAndTheWindow) {
  host::CameraDescription camera = scene().GetCameras().at("/camera");
  camera.parameters["focalLength"] = 0.8371f;
  camera.parameters["horizontalApertureOffset"] = 0.0123f;
  camera.parameters["fStop"] = 0.02;
  camera.parameters["focusDistance"] = 3.1f;
  camera.parameters["apertureBlades"] = 5;
  camera.parameters["clippingRange"] = Vec2f(0.5f, 100);
  camera.parameters["clipPlanes"] = Array<Vec4f>{{1, 0, 0, 0.4f}};
  camera.transform[3][0] = 0.1;
  state_.freeCamera = camera;
  state_.windowPolicy = WindowPolicy::fit;
  state_.framing.pixelAspectRatio = 1.25f;
  state_.framing.displayMin = {-3, 2};
  state_.framing.displayMax = {37, 22};
  expect_same_picture();
  EXPECT_EQ(document()["settings"]["resolution"], json({40, 20}));
  EXPECT_EQ(document()["settings"]["crop"], json({3, -2, 27, 14}));
  EXPECT_EQ(document()["products"][0]["file"], "copy.exr");
}

TEST_F(WrittenScene, HoldsMotion) {
  host::CameraDescription camera = scene().GetCameras().at("/camera");
  camera.parameters["shutterOpen"] = -0.25f;
  camera.parameters["shutterClose"] = 0.5f;
  Matrix4d there = camera.transform;
  there[3][0] = 0.5;
  camera.transformSamples = {{0, 1}, {camera.transform, there}};
  scene().SetCamera("/camera", camera);
  host::MeshDescription quad = Stage::quad();
  quad.transformSamples = {{-1, 0, 1}, {Matrix4d().setScale(Vec3d(2)), Matrix4d(), Matrix4d().setScale(Vec3d(0.5))}};
  scene().SetMesh("/quad", quad);
  ASSERT_EQ(write(), "");
  const Pixels before = picture(), after = picture_of(file());
  ASSERT_EQ(before.size(), after.size());
  for (size_t i = 0; i < before.size(); ++i) EXPECT_NEAR(before[i], after[i], 1e-4f) << i;
}

// To normalize what is normalized may change a last bit; the reader normalizes.
TEST_F(WrittenScene, KeepsNormalsThatWereNormalizedOnce) {
  std::vector<Vec3f> points, normals;
  std::vector<int32_t> indices;
  size_t unstable = 0;
  for (int i = 0; i < 3000; ++i) {
    const float t = float(i);
    points.emplace_back(std::sin(t), std::cos(2 * t), 0.001f * t);
    normals.push_back(Vec3f(std::sin(1.3f * t), std::cos(0.7f * t), std::sin(2.1f * t)).normalized());
    unstable += normals.back() != normals.back().normalized();
    indices.push_back(i);
  }
  EXPECT_GT(unstable, 100u);
  host::MeshDescription mesh;
  mesh.topology.faceVertexCounts = std::vector<int32_t>(1000, 3);
  mesh.topology.faceVertexIndices = indices;
  mesh.primvars["points"].value = Array<Vec3f>(points);
  mesh.primvars["normals"].value = Array<Vec3f>(normals);
  scene().SetMesh("/quad", mesh);
  ASSERT_EQ(write(), "");
  host::RetainedSceneDelegate read;
  ASSERT_TRUE(LoadScene(file(), &read, {}).ok);
  const auto& primvars = read.GetMeshes().begin()->second.primvars;
  EXPECT_EQ(primvars.at("points").value, mesh.primvars["points"].value);
  const auto& written = *primvars.at("normals").value.get<Array<Vec3f>>();
  ASSERT_EQ(written.size(), normals.size());
  size_t differ = 0;
  for (size_t i = 0; i < normals.size(); ++i) differ += written[i] != normals[i];
  EXPECT_EQ(differ, 0u);
}

TEST_F(WrittenScene, IsRecordedUnderItsName) {
  ASSERT_EQ(write(), "");
  Stage other;
  LoadOptions options;
  const SceneFile loaded = LoadScene(file(), &other.scene, {}, options);
  ASSERT_TRUE(loaded.ok) << "nothing lies outside of the folder";
  const RenderSettingsDescription settings = other.scene.GetRenderSettings(loaded.settings);
  ASSERT_EQ(settings.products.size(), 1u);
  EXPECT_EQ(settings.products[0].file, file("copy.exr"));
  EXPECT_EQ(settings.settings.at("samples").number_or(0), 4);
}

}  // namespace
}  // namespace alabaster::hd::description
