// The default look: the scenes that get a studio, its parts, and where they stand.
#include <cmath>

#include "delegate/description/placement.h"
#include "testenv/unit/delegate/description/scene_fixture.h"

namespace alabaster::hd::description {
namespace {

const Path kBackdrop = "/studio/backdrop";

class StudioTest : public SceneFiles {
 protected:
  /// The patch in a description with this camera, lights and settings.
  SceneFile patch(const std::string& rest, const std::string& transform = "{}") {
    empty_scene();
    return describe(R"({"gltf": [{"file": "patch.gltf", "transform": )" + transform + "}]" + rest + "}");
  }
  void empty_scene() {
    std::vector<Path> all{kBackdrop};
    for (const auto& [path, light] : scene.GetLights()) all.push_back(path);
    for (const auto& [path, mesh] : scene.GetMeshes()) all.push_back(path);
    for (const Path& path : all) scene.Remove(path);
  }
  std::string lights() const {
    std::string all;
    for (const auto& [path, light] : scene.GetLights()) all += path.str() + " ";
    return all;
  }
  bool has_backdrop() const { return scene.GetMeshes().contains(kBackdrop); }
  Vec3d light_place(const std::string& name) const {
    return scene.GetLights().at(Path("/lights/" + name)).transform.translation();
  }
  Matrix4d camera(const SceneFile& file) const {
    return scene.GetCameras().at(scene.GetAllRenderSettings().at(file.settings).camera).transform;
  }
  /// The lowest world height of the backdrop.
  double floor() const {
    const host::MeshDescription& mesh = scene.GetMeshes().at(kBackdrop);
    double lowest = INFINITY;
    for (const Vec3f& p : *mesh.primvars.at("points").value.get<Array<Vec3f>>())
      lowest = std::min(lowest, (Vec3d(p) * mesh.transform).y);
    return lowest;
  }
};

constexpr const char* kFront = R"(, "camera": {"lookAt": {"eye": [0, 0.5, 9], "target": [0, 0, 0]}})";
constexpr const char* kStudioLights = "/lights/studio_dome /lights/studio_fill /lights/studio_key /lights/studio_rim ";

TEST_F(StudioTest, ASceneWithoutCameraAndLightHasLightsAndABackdrop) {
  const SceneFile file = patch("");
  ASSERT_TRUE(file.ok) << errors();
  EXPECT_EQ(lights(), kStudioLights);
  ASSERT_TRUE(has_backdrop());
  const double radius = std::sqrt(2.0);
  EXPECT_LT(floor(), -1) << "below the objects";
  EXPECT_NEAR(floor(), -1, 1e-3 * radius) << "which seem to stand on it";
}

// The viewer's left and right, above and behind, whichever way the camera looks.
TEST_F(StudioTest, LightsStandRoundTheObjectsAsTheCameraSeesThem) {
  for (const char* eye : {"[0, 1, 9]", "[9, 2, 0]", "[-5, 3, -5]"}) {
    const SceneFile file = patch(std::string(R"(, "camera": {"lookAt": {"target": [0, 0, 0], "eye": )") + eye + "}}");
    ASSERT_TRUE(file.ok) << errors();
    const Matrix4d to_camera = camera(file).inverse();
    const Vec3d middle = Vec3d(0) * to_camera, key = light_place("studio_key") * to_camera,
                fill = light_place("studio_fill") * to_camera, rim = light_place("studio_rim") * to_camera;
    EXPECT_LT(key.x, -1) << eye;
    EXPECT_GT(key.z, middle.z + 1) << "on the viewer's side";
    EXPECT_GT(fill.x, 1) << eye;
    EXPECT_LT(rim.z, middle.z - 1) << "behind";
    for (const char* name : {"studio_key", "studio_fill", "studio_rim"}) {
      EXPECT_GT(light_place(name).y, 0.5) << name;
      const Matrix4d& m = scene.GetLights().at(Path("/lights/" + std::string(name))).transform;
      const Vec3d aim(-m[2][0], -m[2][1], -m[2][2]);
      EXPECT_NEAR(aim.dot(-m.translation().normalized()), 1, 1e-9) << name << " faces the objects";
    }
  }
}

TEST_F(StudioTest, AFilesOwnCameraSeesNoBackdropUnlessItIsAskedFor) {
  SceneFile file = patch(kFront);
  ASSERT_TRUE(file.ok) << errors();
  EXPECT_EQ(file.notes, (std::vector<std::string>{"no light: added the lights of a studio (studio=on: with a "
                                                  "backdrop; studio=off: a soft dome)"}));
  EXPECT_EQ(lights(), kStudioLights);
  EXPECT_FALSE(has_backdrop());

  file = patch(std::string(kFront) + R"(, "settings": {"studio": "on"})");
  EXPECT_EQ(file.notes, (std::vector<std::string>{"studio=on: added a studio, lights and a backdrop"}));
  EXPECT_TRUE(has_backdrop());
}

TEST_F(StudioTest, OffAddsASoftDome) {
  const SceneFile file = patch(R"(, "settings": {"studio": "off"})");
  ASSERT_TRUE(file.ok) << errors();
  EXPECT_EQ(file.notes, (std::vector<std::string>{"no camera: framed the scene", "no light: added a soft dome"}));
  EXPECT_EQ(lights(), "/lights/default_dome ");
  EXPECT_FALSE(has_backdrop());
  EXPECT_FALSE(scene.GetMaterials().contains("/materials/studio_backdrop"));
}

TEST_F(StudioTest, ACameraAmongTheObjectsHasADome) {
  const SceneFile file = patch(R"(, "camera": {"lookAt": {"eye": [0.5, 0, 0], "target": [0, 0, -1]}})");
  ASSERT_TRUE(file.ok) << errors();
  EXPECT_EQ(file.notes, (std::vector<std::string>{"no light: added a soft dome"}));
  EXPECT_EQ(lights(), "/lights/default_dome ");
}

TEST_F(StudioTest, LightsOfTheSceneAreKeptUnlessItIsAskedFor) {
  const std::string own =
      R"(, "lights": [{"name": "lamp", "type": "sphereLight"}, {"name": "sky", "type": "domeLight"}])";
  ASSERT_TRUE(patch(own).ok) << errors();
  EXPECT_EQ(lights(), "/lights/lamp /lights/sky ");
  EXPECT_FALSE(has_backdrop());
  const SceneFile file = patch(own + R"(, "settings": {"studio": "on"})");
  ASSERT_TRUE(file.ok) << errors();
  EXPECT_EQ(lights(), "/lights/sky /lights/studio_fill /lights/studio_key /lights/studio_rim ") << "domes stay";
  EXPECT_TRUE(has_backdrop());
  EXPECT_NE(file.notes.back().find("in place of the scene's lights"), std::string::npos);
}

TEST_F(StudioTest, ObjectsThatEmitLightNeedNone) {
  const SceneFile file = patch(R"(, "materials": [{"match": "*", "set": {"emission": [1, 0, 0]}}])");
  ASSERT_TRUE(file.ok) << errors();
  EXPECT_EQ(lights(), "");
}

TEST_F(StudioTest, DisplaysAndUnlitSurfacesAreNoLights) {
  const std::string authored = R"("materials": [{"name": "skin"}])";
  for (const char* materials :
       {R"("textures": [{}], "materials": [{"emissiveFactor": [1, 1, 1], "emissiveTexture": {"index": 0}}])",
        R"("extensionsUsed": ["KHR_materials_unlit"], "materials": [{"extensions": {"KHR_materials_unlit": {}}}])"}) {
    std::string gltf = patch_gltf(false, false);
    write("patch.gltf", gltf.replace(gltf.find(authored), authored.size(), materials));
    ASSERT_TRUE(patch("").ok) << errors();
    EXPECT_EQ(lights(), kStudioLights) << materials;
  }
}

TEST_F(StudioTest, StudioScalesWithTheObjects) {
  ASSERT_TRUE(patch("").ok) << errors();
  const Vec3d key = light_place("studio_key");
  const double floor_of_one = floor();
  const double width = scene.GetLights().at("/lights/studio_key").parameters.at("width").number_or(0);
  for (const char* scale : {"0.001", "10000"}) {
    const double s = std::stod(scale);
    const std::string number(scale);
    ASSERT_TRUE(patch("", R"({"scale": [)" + number + "," + number + "," + number + "]}").ok) << errors();
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(light_place("studio_key")[i] / s, key[i], 1e-6) << scale;
    EXPECT_NEAR(floor() / s, floor_of_one, 1e-6);
    EXPECT_NEAR(scene.GetLights().at("/lights/studio_key").parameters.at("width").number_or(0) / s, width, 1e-5);
  }
}

TEST_F(StudioTest, NoBackdropHidesTheObjectsFromACameraBelowThem) {
  const SceneFile file = patch(R"(, "camera": {"lookAt": {"eye": [0, -4, 4], "target": [0, 0, 0]}},
    "settings": {"studio": "on"})");
  ASSERT_TRUE(file.ok) << errors();
  EXPECT_FALSE(has_backdrop());
  EXPECT_EQ(file.notes, (std::vector<std::string>{"studio=on: added the lights of a studio"}));
}

// A camera that looks straight down has the key at the left of its picture, too.
TEST_F(StudioTest, ACameraFromAboveHasItsKeyAtTheLeft) {
  const SceneFile file = patch(R"(, "camera": {"lookAt": {"eye": [0, 9, 0], "target": [0, 0, 0], "up": [1, 0, 0]}})");
  ASSERT_TRUE(file.ok) << errors();
  const Matrix4d to_camera = camera(file).inverse();
  EXPECT_LT((light_place("studio_key") * to_camera).x, -1);
  EXPECT_LT((light_place("studio_key") * to_camera).y, -1) << "on the viewer's side: below in the picture";
  EXPECT_GT((light_place("studio_rim") * to_camera).y, 1);
}

TEST_F(StudioTest, PointsWithoutSizeHaveADome) {
  const SceneFile file = describe("{}");
  ASSERT_TRUE(file.ok) << errors();
  EXPECT_EQ(lights(), "/lights/default_dome ");
}

}  // namespace
}  // namespace alabaster::hd::description
