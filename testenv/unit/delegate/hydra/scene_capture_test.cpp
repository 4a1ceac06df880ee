// The files of a captured scene: their content, and the faults where they cannot hold it.
#include "delegate/hydra/scene_capture.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "testenv/support/stage.h"

namespace alabaster::hydra {
namespace {

using hd::Array;
using hd::Value;
using hd::Vec3f;
using nlohmann::json;

/// A triangle of one material under a sun, as a host describes it.
struct Captured {
  Captured() {
    mesh.topology.scheme = "none";
    mesh.topology.faceVertexCounts = {3};
    mesh.topology.faceVertexIndices = {0, 1, 2};
    mesh.primvars["points"].value = Array<Vec3f>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    mesh.material = "/m";
    network.nodes["/m/s"] = {"AlabasterDisney", {{"roughness", 0.25f}}, {}};
    network.nodes["/m/t"] = {"AlabasterTexture", {{"file", image}}, {}};
    network.terminals["surface"] = {"/m/s", "surface"};
    sun.type = "distantLight";
    state.freeCamera = hd::CameraDescription{};
    state.framing.dataWindow = {0, 0, 8, 8};
  }
  hd::MaterialNode& surface() { return network.nodes["/m/s"]; }

  /// The fault, or nothing.
  std::string write() {
    scene.SetMesh("/mesh", mesh);
    scene.SetMaterial("/m", network);
    scene.SetLight("/sun", sun);
    SceneCapture capture;
    capture.TakeMesh(scene, "/mesh");
    capture.TakeMaterial(scene, "/m");
    capture.TakeLight(scene, "/sun", sun.type);
    return capture.Write(stem + ".json", state, {});
  }
  json document(const char* ending) const { return json::parse(std::ifstream(stem + ending)); }
  ~Captured() {
    for (const char* ending : {".json", ".gltf", ".bin"}) std::filesystem::remove(stem + ending);
  }

  std::string stem = ::testing::TempDir() + "capture_" + std::to_string(getpid());
  std::string image = ::testing::TempDir() + "skin.png";
  hd::Stage stage;
  hd::host::RetainedSceneDelegate& scene = stage.scene;
  hd::host::MeshDescription mesh;
  hd::MaterialNetwork network;
  hd::host::LightDescription sun;
  hd::RenderPassState state;
};

TEST(SceneCapture, ATextureNeedsNoMoreThanItsFile) {
  Captured c;
  c.surface().inputConnections["baseColor"] = {{"/m/t", "rgb"}};
  c.network.nodes["/m/t"].parameters["st"] = hd::Token("map");
  ASSERT_EQ(c.write(), "");
  const json written = c.document(".json")["materials"][0]["replace"];
  EXPECT_EQ(written["baseColor"],
            json({{"file", "skin.png"}, {"colorSpace", "auto"}, {"wrap", "repeat"}, {"st", "map"}}));
  EXPECT_EQ(written["roughness"], 0.25);
}

TEST(SceneCapture, MeshesKeepTheirSides) {
  for (const bool both : {false, true}) {
    Captured c;
    c.mesh.doubleSided = both;
    ASSERT_EQ(c.write(), "");
    EXPECT_EQ(c.document(".gltf")["materials"][0]["doubleSided"], both);
  }
}

TEST(SceneCapture, MeshesThatThePassDoesNotDrawAreLeftOut) {
  Captured c;
  c.mesh.renderTag = "proxy";
  ASSERT_EQ(c.write(), "");
  EXPECT_FALSE(c.document(".gltf").contains("meshes"));
  c.state.renderTags = {"geometry", "proxy"};
  ASSERT_EQ(c.write(), "");
  EXPECT_EQ(c.document(".gltf")["meshes"].size(), 1u);
}

TEST(SceneCapture, ConvexPolygonsAreFans) {
  Captured c;
  c.mesh.topology.faceVertexCounts = {4, 3};
  c.mesh.topology.faceVertexIndices = {0, 1, 2, 3, 0, 3, 4};
  c.mesh.primvars["points"].value = Array<Vec3f>{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {-1, 0, 0}};
  ASSERT_EQ(c.write(), "");
  const json primitive = c.document(".gltf")["meshes"][0]["primitives"][0];
  const json accessor = c.document(".gltf")["accessors"][primitive["indices"].get<size_t>()];
  const json view = c.document(".gltf")["bufferViews"][accessor["bufferView"].get<size_t>()];
  std::vector<uint32_t> indices(accessor["count"].get<size_t>());
  std::ifstream bytes(c.stem + ".bin", std::ios::binary);
  bytes.seekg(view["byteOffset"].get<long>());
  bytes.read(reinterpret_cast<char*>(indices.data()), static_cast<std::streamsize>(4 * indices.size()));
  EXPECT_EQ(indices, (std::vector<uint32_t>{0, 1, 2, 0, 2, 3, 0, 3, 4}));
}

TEST(SceneCapture, PreviewSurfacesAreWrittenAsWhatTheyBecome) {
  Captured c;
  c.surface() = {"UsdPreviewSurface",
                 {{"diffuseColor", Vec3f(0.5f, 0.25f, 0.75f)}, {"clearcoat", 0.5f}, {"opacityThreshold", 0.25f}},
                 {{"roughness", {{"/m/t", "g"}}}}};
  c.network.nodes["/m/t"] = {"UsdUVTexture", {{"file", c.image}, {"wrapS", "clamp"}, {"wrapT", "clamp"}}, {}};
  ASSERT_EQ(c.write(), "");
  const json written = c.document(".json")["materials"][0]["replace"];
  EXPECT_EQ(written["baseColor"], json({0.5, 0.25, 0.75}));
  EXPECT_EQ(written["coat"], 0.5);
  EXPECT_EQ(written["opacityThreshold"], 0.25);
  EXPECT_EQ(written["roughness"],
            json({{"file", "skin.png"}, {"colorSpace", "auto"}, {"wrap", "clamp"}, {"st", "st"}, {"channel", "g"}}));
}

struct Refusal {
  const char* says;
  void (*edit)(Captured&);
};
const Refusal kRefusals[] = {
    {"/mesh is a cage with two points at one place",
     [](Captured& c) {
       c.mesh.topology.scheme = "catmullClark";
       c.mesh.primvars["points"].value = Array<Vec3f>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 0, 0}};
     }},
    {"/mesh has creaseMethod chaikin",
     [](Captured& c) { c.mesh.topology.scheme = "loop", c.mesh.subdivTags.creaseMethod = "chaikin"; }},
    {"/mesh hides sides", [](Captured& c) { c.mesh.cullStyle = hd::CullStyle::front; }},
    {"/mesh deforms",
     [](Captured& c) {
       const Value points = c.mesh.primvars["points"].value;
       c.mesh.primvarSamples["points"] = {{0, 1}, {points, points}};
     }},
    {"/mesh has a primvar subsurfaceSet", [](Captured& c) { c.mesh.primvars["subsurfaceSet"].value = hd::Token("a"); }},
    {"/mesh has too few displayColor",
     [](Captured& c) {
       c.mesh.material = {}, c.mesh.doubleSided = false;
       c.mesh.primvars["displayColor"].value = Array<Vec3f>{{1, 0, 0}};
     }},
    {"/sun is linked", [](Captured& c) { c.sun.parameters["lightLink"] = hd::Token("some"); }},
    {"/m displaces",
     [](Captured& c) {
       c.network.terminals["displacement"] = {"/m/d", "displacement"};
     }},
    {"/m has a bump by rgb",
     [](Captured& c) {
       c.surface().inputConnections["bump"] = {{"/m/t", "rgb"}};
     }},
    {"/m reads /m/gone",
     [](Captured& c) {
       c.surface().inputConnections["sheen"] = {{"/m/gone", "r"}};
     }},
    {"/m has a texture with stOffset",
     [](Captured& c) {
       c.surface().inputConnections["sheen"] = {{"/m/t", "r"}};
       c.network.nodes["/m/t"].parameters["stOffset"] = hd::Vec2f(1, 0);
     }},
    {"/m is neither a UsdPreviewSurface", [](Captured& c) { c.surface().nodeTypeId = "ND_unlit_surface"; }},
    {"/mesh has a face that is not convex",
     [](Captured& c) {
       c.mesh.topology.faceVertexCounts = {4};
       c.mesh.topology.faceVertexIndices = {0, 1, 2, 3};
       c.mesh.primvars["points"].value = Array<Vec3f>{{0, 0, 0}, {0, 0, 1}, {0.2f, 0, 0.2f}, {1, 0, 0}};
     }},
    {"/mesh has faces of fewer", [](Captured& c) { c.mesh.topology.faceVertexCounts = {4}; }},
};

TEST(SceneCapture, FilesCannotHoldAllAndSayWhat) {
  for (const Refusal& refusal : kRefusals) {
    Captured c;
    refusal.edit(c);
    const std::string fault = c.write();
    EXPECT_TRUE(fault.starts_with(refusal.says)) << fault << ", not " << refusal.says;
    EXPECT_FALSE(std::filesystem::exists(c.stem + ".json"));
  }
}

}  // namespace
}  // namespace alabaster::hydra
