// An open scene: a scene that is posed again is the one that a load for that time gives, and costs what moves.
#include <cmath>
#include <ctime>
#include <functional>

#include "delegate/archive/archive.h"
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
constexpr const char* kChanges = R"({
  "gltf": [{"file": "made.glb", "time": 0.25,
            "motion": [{"time": 0, "transform": {"translate": [0, 0, 0]}}, {"time": 1, "transform": {"translate": [0, 1, 0]}}]}],
  "meshes": [{"match": "left", "holdout": true, "material": "wax", "corners": [{"point": 1}]},
             {"match": "*", "subsurfaceSet": "all", "scheme": "loop"},
             {"match": "*", "material": "skin"},
             {"match": "arm", "visible": false}],
  "lights": [{"match": "lamp", "intensity": 3, "position": [1, 2, 3], "lightLink": ["[rs]*"]},
             {"name": "key", "type": "rectLight", "shadowLink": ["l*"]}],
  "camera": {"use": "front", "fStop": 2}})";

class OpenSceneTest : public SceneFiles {
 protected:
  void expect_posed_as_loaded(const std::string& name, const LoadOptions& given) {
    LoadOptions options = given;
    options.time = 0.1;
    host::RetainedSceneDelegate scene;
    OpenScene source;
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

TEST_F(OpenSceneTest, APoseIsWhatALoadForItsTimeGives) {
  write("made.glb", animated().bytes());
  write("made.json", kChanges);
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

// The nodes are instances from 1 to 2 s, and move by themselves at other times alone.
TEST_F(OpenSceneTest, APoseThatFailsLeavesTheSceneAndIsMadeUpForByTheNext) {
  write("made.glb", animated().bytes());
  const std::string file = write("made.json", R"({"models": [{"file": "made.glb"}, {"file": "made.glb"}],
    "meshes": [{"match": "/copy2*left*", "motion": [{"time": 0, "transform": {}}, {"time": 1, "transform": {}}]}]})");
  for (const double close : {0.0, 0.5}) {
    LoadOptions options;
    options.time = 0.1;
    options.shutter = {0, close};
    OpenScene source;
    host::RetainedSceneDelegate posed, fresh;
    ASSERT_TRUE(source.Load(file, &posed, sink(), options).ok) << errors();
    const host::Prims before = posed.GetPrims();
    EXPECT_EQ(source.Pose(1.5, sink()), LoadCause::input);
    EXPECT_NE(errors().find("is drawn several times"), std::string::npos) << errors();
    EXPECT_TRUE(before == posed.GetPrims());
    options.time = 1e6;  // where all stands still
    ASSERT_EQ(source.Pose(*options.time, sink()), LoadCause::none) << errors();
    ASSERT_TRUE(LoadScene(file, &fresh, sink(), options).ok) << errors();
    EXPECT_TRUE(fresh.GetPrims() == posed.GetPrims());
  }
}

// Two primitives of a square, which a scheme makes one control mesh.
TEST_F(OpenSceneTest, AWeldedMeshKeepsItsSeams) {
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

TEST_F(OpenSceneTest, WithoutAnAnimationOrASceneNothingMoves) {
  OpenScene source;
  EXPECT_EQ(source.Pose(1, {}), LoadCause::input) << "nothing is loaded";
  ASSERT_TRUE(source.Load(folder_ / "lit.gltf", &scene, {}, {}).ok);
  const host::Prims before = scene.GetPrims();
  EXPECT_EQ(source.Pose(1, {}), LoadCause::none);
  EXPECT_TRUE(before == scene.GetPrims());
  EXPECT_FALSE(source.Load(folder_ / "none.gltf", &scene, {}, {}).ok);
  EXPECT_EQ(source.Pose(1, {}), LoadCause::input);
}

double cpu_ms(const std::function<void()>& work) {
  const std::clock_t begin = std::clock();
  work();
  return double(std::clock() - begin) * 1000 / CLOCKS_PER_SEC;
}

// A node of many moves, and a mesh of many points stands still.
TEST_F(OpenSceneTest, APoseCostsWhatMoves) {
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
    OpenScene source;
    const double load = cpu_ms([&] { ASSERT_TRUE(source.Load(folder_ / "many.glb", &scene, {}, options).ok); });
    constexpr int kPoses = 20;
    const double poses = cpu_ms([&] {
      for (int i = 1; i <= kPoses; ++i) EXPECT_EQ(source.Pose(i, {}), LoadCause::none);
    });
    EXPECT_LT(poses / kPoses, load / 10) << "with a shutter of " << close;
    EXPECT_EQ(scene.GetMeshes().at("/gltf/many/nodes/0/0").transform.translation().x, kPoses);
  }
}

// Over the shutter -------------------------------------------------------------------------------

// Five samples, in frames, and none for things that stand still.
TEST_F(OpenSceneTest, AnOpenShutterGivesSamples) {
  GltfBuilder b;
  b.triangle();
  b.primitive()["targets"] = {{{"POSITION", b.add<float>({0, 0, 2, 0, 0, 2, 0, 0, 2}, "VEC3")}}};
  b.json["nodes"] = {{{"mesh", 0}}, {{"mesh", 0}, {"weights", {1}}, {"translation", {9, 0, 0}}}};
  b.json["scenes"][0]["nodes"] = {0, 1};
  b.animate(0, "weights", {0, 1}, {0, 1}, "SCALAR");
  b.animate(1, "translation", {0, 1}, {9, 0, 0, 5, 0, 0}, "VEC3");
  write("made.glb", b.bytes());
  LoadOptions options;
  options.time = 0.5;
  options.frames_per_second = 8;
  options.shutter = {-2, 2};
  ASSERT_TRUE(LoadScene(folder_ / "made.glb", &scene, {}, options).ok);
  const auto& deforming = scene.GetMeshes().at("/gltf/made/nodes/0/0");
  const auto& moving = scene.GetMeshes().at("/gltf/made/nodes/1/0");
  const std::vector<double> times{-2, -1, 0, 1, 2};
  const auto& points = deforming.primvarSamples.at("points");
  ASSERT_EQ(points.times, times);
  EXPECT_EQ(points.values[2], deforming.primvars.at("points").value);
  for (size_t i = 0; i < 5; ++i)
    EXPECT_NEAR((*points.values[i].get<Array<Vec3f>>())[1].z, 2 * (0.25 + 0.125 * double(i)), 1e-6);
  EXPECT_TRUE(deforming.transformSamples.values.empty());
  ASSERT_EQ(moving.transformSamples.times, times);
  for (size_t i = 0; i < 5; ++i) EXPECT_EQ(moving.transformSamples.values[i].translation().x, 8 - 0.5 * double(i));
  EXPECT_TRUE(moving.primvarSamples.empty());
}

// Each node of a mesh that several nodes place moves by itself.
TEST_F(OpenSceneTest, InstancesHaveSamples) {
  GltfBuilder b;
  b.triangle();
  b.json["nodes"] = {{{"mesh", 0}}, {{"mesh", 0}}};
  b.json["scenes"][0]["nodes"] = {0, 1};
  b.animate(1, "translation", {0, 1}, {0, 0, 0, 4, 0, 0}, "VEC3");
  write("made.glb", b.bytes());
  LoadOptions options;
  options.frames_per_second = 1;
  options.shutter = {0, 1};
  ASSERT_TRUE(LoadScene(folder_ / "made.glb", &scene, {}, options).ok);
  ASSERT_EQ(scene.GetInstancers().size(), 1u);
  const auto& samples = scene.GetInstancers().begin()->second.primvarSamples.at("hydra:instanceTransforms");
  ASSERT_EQ(samples.times.size(), 5u);
  for (size_t i = 0; i < 5; ++i) {
    const auto& placed = *samples.values[i].get<Array<Matrix4d>>();
    EXPECT_EQ(placed[0], Matrix4d());
    EXPECT_EQ(placed[1].translation().x, double(i));
  }
}

/// A wheel that turns about z by `degrees` in a second, with things at radius 1: a mesh below its node, two nodes that
/// share a mesh, and a mesh that follows a skin.
GltfBuilder wheel(double degrees) {
  GltfBuilder b;
  b.triangle();
  gltf::testing::Json skinned = b.primitive();
  skinned["attributes"]["POSITION"] = b.add<float>({1, 0, 0, 1.1f, 0, 0, 1, 0.1f, 0}, "VEC3");
  skinned["attributes"]["JOINTS_0"] = b.add<uint8_t>(std::vector<uint8_t>(12, 0), "VEC4");
  skinned["attributes"]["WEIGHTS_0"] = b.add<float>({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4");
  const gltf::testing::Json plain = b.primitive();
  b.json["meshes"] = {{{"primitives", {plain}}}, {{"primitives", {plain}}}, {{"primitives", {skinned}}}};
  b.json["meshes"][1]["primitives"][0]["material"] = 0;  // else it is the same mesh as the first
  b.json["materials"] = {{{"name", "wax"}}};
  b.json["skins"] = {{{"joints", {0}}}};
  b.json["nodes"] = {{{"children", {1, 2, 3}}},
                     {{"mesh", 0}, {"translation", {1, 0, 0}}},
                     {{"mesh", 1}, {"translation", {0, 1, 0}}},
                     {{"mesh", 1}, {"translation", {0, -1, 0}}},
                     {{"mesh", 2}, {"skin", 0}}};
  b.json["scenes"][0]["nodes"] = {0, 4};
  std::vector<float> times, turns;
  for (int i = 0; i <= 16; ++i) {
    const double half = degrees / 16 * i * std::acos(-1.0) / 360;
    times.push_back(float(i) / 16);
    for (const double q : {0.0, 0.0, std::sin(half), std::cos(half)}) turns.push_back(float(q));
  }
  b.animate(0, "rotation", times, turns, "VEC4");
  return b;
}

// Half way from one sample to the next, too, where a renderer moves it along a line.
TEST_F(OpenSceneTest, AWheelKeepsItsRadiusAtAnySpeed) {
  const auto expect_on_circle = [](const Vec3d& a, const Vec3d& b, double tolerance = 1e-3) {
    for (const Vec3d& p : {a, (a + b) * 0.5}) EXPECT_NEAR(std::hypot(p.x, p.y), 1, tolerance) << p.x << " " << p.y;
  };
  size_t samples = 0;
  for (const double degrees : {10.0, 180.0, 600.0}) {
    SCOPED_TRACE(degrees);
    write("wheel.glb", wheel(degrees).bytes());
    LoadOptions options;
    options.frames_per_second = 1;
    options.shutter = {0, 1};
    host::RetainedSceneDelegate loaded;
    ASSERT_TRUE(LoadScene(folder_ / "wheel.glb", &loaded, {}, options).ok);
    const auto& moved = loaded.GetMeshes().at("/gltf/wheel/nodes/1/0").transformSamples.values;
    const auto& placed = loaded.GetInstancers().begin()->second.primvarSamples.at("hydra:instanceTransforms").values;
    const auto& bent = loaded.GetMeshes().at("/gltf/wheel/nodes/4/0").primvarSamples.at("points").values;
    ASSERT_EQ(loaded.GetInstancers().size(), 1u);
    EXPECT_GE(moved.size(), samples) << "no fewer than of a slower one";
    EXPECT_LE(moved.size(), 129u);
    samples = moved.size();
    EXPECT_EQ(placed.size(), samples);
    EXPECT_EQ(bent.size(), std::min<size_t>(samples, 33)) << "points take more memory";
    for (size_t i = 0; i + 1 < samples; ++i) {
      expect_on_circle(moved[i].translation(), moved[i + 1].translation());
      for (const size_t instance : {0, 1})
        expect_on_circle((*placed[i].get<Array<Matrix4d>>())[instance].translation(),
                         (*placed[i + 1].get<Array<Matrix4d>>())[instance].translation());
    }
    for (size_t i = 0; i + 1 < bent.size() && degrees <= 180; ++i)
      expect_on_circle(Vec3d((*bent[i].get<Array<Vec3f>>())[0]), Vec3d((*bent[i + 1].get<Array<Vec3f>>())[0]), 1.3e-3);
    if (degrees == 10.0) {
      EXPECT_EQ(samples, 5u) << "a slow one needs no more";
    }
  }
}

// Models --------------------------------------------------------------------------------------------

// A scene where z is up has the default camera and studio of the same scene where y is.
// promise: pipeline.archive.facts
TEST_F(OpenSceneTest, TheDefaultLookStandsByTheUpAxis) {
  const Matrix4d turn(1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1);
  const auto load_with = [&](const char* name, const char* up, const Matrix4d& placed, const char* description) {
    host::RetainedSceneDelegate made;
    host::MeshDescription mesh;
    mesh.topology.faceVertexCounts = {3, 3};
    mesh.topology.faceVertexIndices = {0, 1, 2, 0, 1, 3};
    mesh.primvars["points"].value = Array<Vec3f>{{0, 0, 0}, {3, 0, 0}, {0, 2, 0}, {0, 0, 1}};
    mesh.transform = placed;
    made.SetMesh("/corner", mesh);
    host::SceneInfo info;
    info.up = up;
    EXPECT_EQ(archive::WriteArchive(folder_ / (std::string(name) + ".alab"), made.GetPrims(), info), "");
    auto loaded = std::make_unique<host::RetainedSceneDelegate>();
    const std::string file = write(std::string(name) + ".json", std::string(R"({"models": [{"file": ")") + name +
                                                                    R"(.alab"}], )" + description + "}");
    EXPECT_TRUE(LoadScene(file, loaded.get(), {}).ok);
    return loaded;
  };
  for (const char* description :
       {R"("settings": {"studio": "on"})",
        R"("settings": {"studio": "on"}, "camera": {"lookAt": {"eye": [9, 0, 0], "target": [0, 0, 0]}})"}) {
    const auto y = load_with("y", "Y", Matrix4d(), description), z = load_with("z", "Z", turn, description);
    const auto expect_turned = [&](const Path& path, const Matrix4d& a, const Matrix4d& b) {
      EXPECT_TRUE((a * turn).equalWithAbsError(b, 1e-12)) << path.str() << "\n" << a << b;
    };
    ASSERT_EQ(y->GetLights().size(), 4u);
    for (const auto& [path, light] : y->GetLights())
      if (light.type != Token("domeLight")) expect_turned(path, light.transform, z->GetLights().at(path).transform);
    for (const auto& [path, camera] : y->GetCameras())
      expect_turned(path, camera.transform, z->GetCameras().at(path).transform);
    for (const auto& [path, mesh] : y->GetMeshes())
      expect_turned(path, mesh.transform, z->GetMeshes().at(path).transform);
    EXPECT_TRUE(y->GetMeshes().contains("/studio/backdrop"));
  }
}

}  // namespace
}  // namespace alabaster::hd::description
