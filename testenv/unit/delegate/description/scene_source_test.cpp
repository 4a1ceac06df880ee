// The scene source: a scene that is posed again is the one that a load for that time gives, and costs what moves.
#include <ctime>
#include <functional>

#include "testenv/unit/delegate/description/scene_fixture.h"
#include "testenv/unit/delegate/gltf/gltf_builder.h"

namespace alabaster::hd::description {
namespace {

using gltf::testing::GltfBuilder;

// Nodes 0 and 1: morph weights that agree from 1 to 2 s. 2: stands still. 3: a camera that moves. 4: a light that
// moves. 5: a skin, whose joint 6 turns. 7 and 8: moved together by their parent 9, as instances of one mesh.
GltfBuilder animated() {
  GltfBuilder b;
  b.triangle();
  b.attribute<float>("TEXCOORD_0", {0, 0, 1, 0, 0, 1}, "VEC2");
  b.primitive()["targets"] = {{{"POSITION", b.add<float>({0, 0, 0, 1, 1, 0, 0, 0, 0}, "VEC3")}}};
  gltf::testing::Json still = b.primitive(), skinned = b.primitive();
  still.erase("targets"), skinned.erase("targets");
  skinned["attributes"]["JOINTS_0"] = b.add<uint8_t>(std::vector<uint8_t>(12, 0), "VEC4");
  skinned["attributes"]["WEIGHTS_0"] = b.add<float>({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4");
  still["material"] = 0;
  for (const gltf::testing::Json& primitive : {still, skinned, still})
    b.json["meshes"].push_back({{"primitives", {primitive}}});
  b.json["materials"] = {{{"name", "wax"}}, {{"name", "skin"}}};
  b.json["extensionsUsed"] = {"KHR_lights_punctual"};
  b.json["extensions"]["KHR_lights_punctual"]["lights"] = {{{"name", "lamp"}, {"type", "point"}}};
  b.json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 0.5}, {"znear", 0.1}}}}};
  b.json["skins"] = {{{"joints", {6}}}};
  b.json["nodes"] = {{{"name", "left"}, {"mesh", 0}},
                     {{"name", "right"}, {"mesh", 0}, {"translation", {2, 0, 0}}},
                     {{"name", "still"}, {"mesh", 1}},
                     {{"name", "front"}, {"camera", 0}},
                     {{"name", "lamp"}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}},
                     {{"name", "arm"}, {"mesh", 2}, {"skin", 0}},
                     {{"name", "joint"}},
                     {{"mesh", 3}, {"translation", {0, 2, 0}}},
                     {{"mesh", 3}, {"translation", {0, 3, 0}}},
                     {{"children", {7, 8}}}};
  b.json["scenes"][0]["nodes"] = {0, 1, 2, 3, 4, 5, 6, 9};
  b.animate(0, "weights", {0, 1, 2, 3}, {0, 0.5f, 0.5f, 1}, "SCALAR");
  b.animate(1, "weights", {0, 1, 2, 3}, {1, 0.5f, 0.5f, 0}, "SCALAR");
  b.animate(3, "translation", {0, 3}, {0, 0, 5, 0, 0, 8}, "VEC3");
  b.animate(4, "translation", {0, 3}, {0, 0, 5, 3, 0, 8}, "VEC3");
  b.animate(6, "rotation", {0, 3}, {0, 0, 0, 1, 0, 0, 1, 0}, "VEC4");
  b.animate(9, "scale", {0, 3}, {1, 1, 1, 2, 2, 2}, "VEC3");
  return b;
}

// Changes that names make to what moves, and what stands still.
constexpr const char* kDescription = R"({
  "gltf": [{"file": "made.glb", "time": 0.25,
            "motion": [{"time": 0, "transform": {"translate": [0, 0, 0]}}, {"time": 1, "transform": {"translate": [0, 1, 0]}}]}],
  "meshes": [{"match": "left", "holdout": true, "material": "wax", "corners": [{"point": 1}]},
             {"match": "*", "subsurfaceSet": "all", "scheme": "loop"},
             {"match": "*", "material": "skin"},
             {"match": "arm", "visible": false}],
  "lights": [{"match": "lamp", "intensity": 3, "position": [1, 2, 3], "lightLink": ["[rs]*"]},
             {"name": "key", "type": "rectLight", "shadowLink": ["l*"]}],
  "camera": {"use": "front", "fStop": 2}})";

class SceneSourceTest : public SceneFiles {
 protected:
  void expect_posed_as_loaded(const std::string& name, const LoadOptions& given) {
    LoadOptions options = given;
    options.time = 0.1;
    host::RetainedSceneDelegate scene;
    SceneSource source;
    const auto sink = [](const Diagnostic& d) { EXPECT_NE(d.severity, Severity::error) << d.where << ": " << d.text; };
    ASSERT_TRUE(source.Load(folder_ / name, &scene, sink, options).ok);
    for (const double time : {0.1, 0.5, 1.5, 1.6, 2.5, 0.0, 1.5, 9.0, 0.5}) {
      ASSERT_EQ(source.Pose(time, sink), LoadCause::none);
      host::RetainedSceneDelegate fresh;
      options.time = time;
      ASSERT_TRUE(LoadScene(folder_ / name, &fresh, sink, options).ok);
      EXPECT_TRUE(scene.GetMeshes() == fresh.GetMeshes())
          << name << " at " << time << "\n"
          << gltf::testing::text_of(scene) << gltf::testing::text_of(fresh);
      EXPECT_TRUE(scene.GetInstancers() == fresh.GetInstancers()) << name << " at " << time;
      EXPECT_TRUE(scene.GetMaterials() == fresh.GetMaterials()) << name << " at " << time;
      EXPECT_TRUE(scene.GetLights() == fresh.GetLights()) << name << " at " << time;
      EXPECT_TRUE(scene.GetCameras() == fresh.GetCameras()) << name << " at " << time;
    }
  }
};

TEST_F(SceneSourceTest, APoseIsWhatALoadForItsTimeGives) {
  write("made.glb", animated().bytes());
  write("made.json", kDescription);
  for (const char* name : {"made.glb", "made.json"})
    for (const double close : {0.0, 0.5}) {
      LoadOptions options;
      options.shutter = {0, close};
      options.frames_per_second = 2;
      expect_posed_as_loaded(name, options);
      options.overrides = {"meshes/[rs]*.refineLevel=3", "lights/lamp.intensity=7"};
      options.camera = "front";
      expect_posed_as_loaded(name, options);
    }
}

// Two primitives of a square, which a scheme makes one control mesh.
TEST_F(SceneSourceTest, AWeldedMeshKeepsItsSeams) {
  gltf::testing::GltfBuilder b;
  b.attribute<float>("POSITION", {0, 0, 0, 1, 0, 0, 1, 1, 0}, "VEC3");
  b.json["meshes"][0]["primitives"].push_back(nlohmann::json::object());
  b.json["meshes"][0]["primitives"][1]["attributes"]["POSITION"] = b.add<float>({0, 0, 0, 1, 1, 0, 0, 1, 0}, "VEC3");
  float y = 0;
  for (auto& primitive : b.json["meshes"][0]["primitives"]) {
    primitive["attributes"]["NORMAL"] = b.add<float>({0, y, 1, 0, y, 1, 0, y, 1}, "VEC3");
    primitive["attributes"]["TEXCOORD_0"] = b.add<float>({0.5f, 1, 0.5f, 1, 0.5f, 1}, "VEC2");
    y = 1;
  }
  write("made.glb", b.bytes());
  ASSERT_TRUE(describe(R"({"gltf": [{"file": "made.glb"}], "meshes": [{"match": "*", "scheme": "loop"}],
    "settings": {"studio": "off"}})")
                  .ok)
      << errors();
  ASSERT_EQ(scene.GetMeshes().size(), 1u);
  const host::MeshDescription& mesh = scene.GetMeshes().begin()->second;
  EXPECT_EQ(mesh.topology.faceVertexIndices, (Array<int32_t>{0, 1, 2, 0, 2, 3}));
  EXPECT_EQ(mesh.primvars.at("points").value, Value(Array<Vec3f>{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}));
  EXPECT_EQ(mesh.primvars.at("st").interpolation, Interpolation::faceVarying);
  EXPECT_EQ(mesh.primvars.at("st").indices, (Array<int32_t>{0, 1, 2, 0, 2, 3})) << "no seam";
  EXPECT_EQ(mesh.primvars.at("normals").indices, (Array<int32_t>{0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(mesh.topology.geomSubsets.at(1).indices, (Array<int32_t>{1}));
}

TEST_F(SceneSourceTest, WithoutAnAnimationOrASceneNothingMoves) {
  SceneSource source;
  EXPECT_EQ(source.Pose(1, {}), LoadCause::input) << "nothing is loaded";
  ASSERT_TRUE(source.Load(folder_ / "lit.gltf", &scene, {}, {}).ok);
  const host::Prims before = scene.GetPrims();
  EXPECT_EQ(source.Pose(1, {}), LoadCause::none);
  EXPECT_TRUE(before == scene.GetPrims());
  EXPECT_FALSE(source.Load(folder_ / "none.gltf", &scene, {}, {}).ok);
  EXPECT_EQ(source.Pose(1, {}), LoadCause::input);
}

double cpu_ms_of(const std::function<void()>& work) {
  const std::clock_t begin = std::clock();
  work();
  return double(std::clock() - begin) * 1000 / CLOCKS_PER_SEC;
}

// A node of many moves, and a mesh of many points stands still.
TEST_F(SceneSourceTest, APoseCostsWhatMoves) {
  constexpr size_t kNodes = 1000;
  GltfBuilder b;
  b.attribute<float>("POSITION", std::vector<float>(300000, 0.5f), "VEC3");
  const gltf::testing::Json large = b.primitive();
  b.json["nodes"] = gltf::testing::Json::array();
  b.json["scenes"][0]["nodes"] = gltf::testing::Json::array();
  b.json["meshes"] = gltf::testing::Json::array();
  const size_t points = b.add<float>({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3");
  for (size_t n = 0; n < kNodes; ++n) {
    b.json["meshes"].push_back({{"primitives", {{{"attributes", {{"POSITION", points}}}}}}});
    b.json["nodes"].push_back({{"mesh", n}});
    b.json["scenes"][0]["nodes"].push_back(n);
  }
  b.json["meshes"][1]["primitives"] = {large};
  b.animate(0, "translation", {0, 100}, {0, 0, 0, 100, 0, 0}, "VEC3");
  write("many.glb", b.bytes());
  for (const double close : {0.0, 0.5}) {
    LoadOptions options;
    options.time = 0;
    options.shutter = {0, close};
    SceneSource source;
    const double load = cpu_ms_of([&] { ASSERT_TRUE(source.Load(folder_ / "many.glb", &scene, {}, options).ok); });
    constexpr int kPoses = 20;
    const double poses = cpu_ms_of([&] {
      for (int i = 1; i <= kPoses; ++i) EXPECT_EQ(source.Pose(i, {}), LoadCause::none);
    });
    EXPECT_LT(poses / kPoses, load / 10) << "with a shutter of " << close;
    EXPECT_EQ(scene.GetMeshes().at("/gltf/many/nodes/0/0").transform.translation().x, kPoses);
  }
}

}  // namespace
}  // namespace alabaster::hd::description
