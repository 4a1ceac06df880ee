// Materials that displace meshes, and cameras that refine them: built at commit, once.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "testenv/support/stage.h"

namespace alabaster::hd {
namespace {

// A Radiance image of one row of grey texels.
AssetPath greys(const std::string& name, const std::vector<float>& values) {
  std::string bytes = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X " + std::to_string(values.size()) + "\n";
  for (const float value : values) {
    int exponent = 0;
    const int mantissa = static_cast<int>(std::frexp(value, &exponent) * 256);
    for (const int b : {mantissa, mantissa, mantissa, exponent + 128}) bytes += static_cast<char>(b);
  }
  AssetPath file;
  file.authored = file.resolved = name;
  file.bytes = std::make_shared<std::vector<uint8_t>>(bytes.begin(), bytes.end());
  return file;
}
AssetPath grey(const std::string& name, float value) {
  return greys(name, {value});
}

MaterialNetwork displacing(const AssetPath& file, float scale = 1) {
  MaterialNetwork network;
  network.nodes["/m/surface"].nodeTypeId = "AlabasterDisney";
  network.nodes["/m/texture"] = {"AlabasterTexture", {{"file", file}}, {}};
  network.nodes["/m/displacement"] = {"AlabasterDisplacement", {{"scale", scale}}, {}};
  network.nodes["/m/displacement"].inputConnections["displacement"] = {{"/m/texture", "r"}};
  network.terminals["surface"] = {"/m/surface", "surface"};
  network.terminals["displacement"] = {"/m/displacement", "displacement"};
  return network;
}

host::MeshDescription square() {
  host::MeshDescription mesh = Stage::quad();
  mesh.primvars["st"] = {Interpolation::vertex, "textureCoordinate", Array<Vec2f>{{0, 0}, {1, 0}, {1, 1}, {0, 1}}, {}};
  mesh.material = "/m";
  return mesh;
}

// The square as a camera at z = 4 sees it.
class Seen : public Stage {
 public:
  Seen() {
    add_basic_scene();
    scene.Remove("/quad");
    buffer_ = add_buffer("/depth", 8, 8, Format::float32);
    pass_ = delegate->CreateRenderPass();
  }
  ~Seen() { pass_.reset(); }
  float height() {
    index->SyncAll();
    EXPECT_TRUE(finish(*pass_, state_for(8, 8, "cameraDepth", buffer_)));
    return 4 - pixels<float>(buffer_)[8 * 4 + 4];
  }
  std::vector<std::string> mesh_lines() {
    std::vector<std::string> lines;
    const std::string text = dump();
    for (size_t at = text.find("  mesh "); at != std::string::npos; at = text.find("  mesh ", at + 1))
      lines.push_back(text.substr(at, text.find('\n', at) - at));
    return lines;
  }

 private:
  RenderBuffer* buffer_;
  std::unique_ptr<RenderPass> pass_;
};

TEST(DisplacementSync, FollowsItsMaterialHoweverTheSceneIsEdited) {
  Seen seen;
  const AssetPath half = grey("half.hdr", 0.5f);
  seen.scene.SetMaterial("/m", displacing(half));
  seen.scene.SetMesh("/square", square());
  EXPECT_NEAR(seen.height(), 0.5f, 1e-3f);
  seen.scene.SetMaterial("/m", displacing(half, 2));
  EXPECT_NEAR(seen.height(), 1, 1e-3f);
  seen.scene.SetMaterial("/m", displacing(grey("quarter.hdr", 0.25f), 2));
  EXPECT_NEAR(seen.height(), 0.5f, 1e-3f);
  MaterialNetwork plain = displacing(half);
  plain.terminals.erase("displacement");
  seen.scene.SetMaterial("/m", plain);
  EXPECT_NEAR(seen.height(), 0, 1e-3f);
  seen.scene.SetMaterial("/m", displacing(half));  // of a mesh that was built without
  EXPECT_NEAR(seen.height(), 0.5f, 1e-3f);
  seen.scene.Remove("/m");
  EXPECT_NEAR(seen.height(), 0, 1e-3f);
  EXPECT_EQ(seen.stat("scene.faultCount"), -1);  // none
}

// An edit of the colour does not build the mesh again, and instances share it.
TEST(DisplacementSync, AMeshIsBuiltOnceForItsInstancesAndOnlyWhenItsShapeChanges) {
  Seen seen;
  seen.scene.SetMaterial("/m", displacing(grey("half.hdr", 0.5f)));
  host::MeshDescription mesh = square();
  mesh.topology.scheme = "bilinear";
  mesh.displayStyle.refineLevel = 5;
  mesh.instancer = "/i";
  seen.scene.SetMesh("/square", mesh);
  host::InstancerDescription instancer;
  instancer.indices["/square"] = {0, 1, 2};
  instancer.primvars["hydra:instanceTranslations"] = Array<Vec3f>{{0, 0, 0}, {5, 0, 0}, {-5, 0, 0}};
  seen.scene.SetInstancer("/i", instancer);
  EXPECT_NEAR(seen.height(), 0.5f, 1e-3f);
  EXPECT_EQ(seen.mesh_lines().size(), 3u);
  EXPECT_NE(seen.delegate->InvokeCommand("requirements", {}).value.text_or("").find("1 meshes"), std::string::npos);
  const double built = seen.stat("sync.refineWallSeconds");
  MaterialNetwork red = seen.scene.GetMaterials().at("/m");
  red.nodes["/m/surface"].parameters["roughness"] = 0.1f;
  seen.scene.SetMaterial("/m", red);
  EXPECT_NEAR(seen.height(), 0.5f, 1e-3f);
  EXPECT_EQ(seen.stat("sync.refineWallSeconds"), built);
}

TEST(DisplacementSync, FaultsAreReportedAndEndWithTheirCause) {
  Seen seen;
  seen.scene.SetMesh("/square", square());
  AssetPath missing;
  missing.authored = missing.resolved = "/nowhere/heights.png";
  seen.scene.SetMaterial("/m", displacing(missing));
  EXPECT_NEAR(seen.height(), 0, 1e-3f);
  EXPECT_EQ(seen.stat("scene.faultCount"), 1);
  const AssetPath half = grey("half.hdr", 0.5f);
  seen.scene.SetMaterial("/m", displacing(half, 1e30f));
  EXPECT_NEAR(seen.height(), 0, 1e-3f);
  EXPECT_EQ(seen.count("mesh.displacement.nonfinite"), 1u);
  EXPECT_EQ(seen.stat("scene.faultCount"), 1);
  seen.scene.SetMaterial("/m", displacing(half));
  EXPECT_NEAR(seen.height(), 0.5f, 1e-3f);
  EXPECT_EQ(seen.stat("scene.faultCount"), -1);  // none
}

// A cube's faces each have the whole image, so heights differ across every edge: no walk finds a hole.
TEST(DisplacementSync, WalksStayInsideADisplacedBodyWithSeams) {
  Seen seen;
  host::MeshDescription cube;
  cube.topology.faceVertexCounts = {4, 4, 4, 4, 4, 4};
  cube.topology.faceVertexIndices = {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5};
  cube.topology.scheme = "catmullClark";
  cube.displayStyle.refineLevel = 4;
  std::vector<Vec3f> points;
  for (int i = 0; i < 8; ++i) points.emplace_back(i & 1 ? 1.0f : -1.0f, i & 2 ? 1.0f : -1.0f, i & 4 ? 1.0f : -1.0f);
  cube.primvars["points"].value = Array<Vec3f>(points);
  std::vector<Vec2f> st;
  for (int face = 0; face < 6; ++face)
    for (const Vec2f& corner : {Vec2f(0, 0), Vec2f(1, 0), Vec2f(1, 1), Vec2f(0, 1)}) st.push_back(corner);
  cube.primvars["st"] = {Interpolation::faceVarying, "textureCoordinate", Array<Vec2f>(st), {}};
  cube.material = "/m";
  MaterialNetwork wax = displacing(greys("row.hdr", {0.05f, 0.3f, 0.1f, 0.4f, 0.02f}), 0.5f);
  wax.nodes["/m/surface"].parameters["scatterDistance"] = Vec3f(0.3f);
  seen.scene.SetMaterial("/m", wax);
  seen.scene.SetMesh("/cube", cube);
  EXPECT_GT(seen.height(), 0.5f);
  EXPECT_EQ(seen.count("mesh.open"), 0u);
  EXPECT_GT(seen.stat("walk.count"), 0);
  EXPECT_EQ(seen.stat("walk.lost"), 0);
  EXPECT_NE(seen.mesh_lines().at(0).find("closed yes"), std::string::npos);
}

// A displacement that cannot be had is named once, and the mesh stays as it is.
TEST(DisplacementSync, NetworksThatSayNoDisplacementAreWarnedOf) {
  Seen seen;
  seen.scene.SetMesh("/square", square());
  MaterialNetwork network = displacing(grey("half.hdr", 0.5f));
  network.terminals["displacement"].upstreamNode = "/m/texture";
  seen.scene.SetMaterial("/m", network);
  EXPECT_NEAR(seen.height(), 0, 1e-3f);
  EXPECT_EQ(seen.count("material.displacement"), 1u);
  network.terminals["displacement"].upstreamNode = "/m/displacement";
  network.nodes["/m/displacement"].inputConnections.clear();
  seen.scene.SetMaterial("/m", network);
  EXPECT_NEAR(seen.height(), 0, 1e-3f);
  EXPECT_EQ(seen.count("material.displacement"), 2u);
}

// 2 units at distance 4 are 32 of 64 pixels: 8 edges of 4 pixels.
TEST(AdaptiveRefinement, FollowsTheCameraTheSettingAndTheInstances) {
  Seen seen;
  RenderSettingsDescription settings;
  settings.camera = "/camera";
  settings.width = settings.height = 64;
  settings.settings["refineEdgeLength"] = 4.0f;
  seen.scene.SetRenderSettings("/settings", settings);
  host::MeshDescription mesh = square();
  mesh.topology.scheme = "bilinear";
  mesh.displayStyle.refineLevel = 1;
  mesh.material = Path();
  seen.scene.SetMesh("/square", mesh);
  const auto triangles = [&] {
    const std::string line = seen.mesh_lines().at(0);
    return std::stoi(line.substr(line.find("triangles ") + 10));
  };
  EXPECT_EQ(triangles(), 2 * 8 * 8);
  host::CameraDescription camera = seen.scene.GetCameras().at("/camera");
  camera.transform[3][2] = 2;
  seen.scene.SetCamera("/camera", camera);
  EXPECT_NEAR(triangles(), 2 * 14 * 14, 100);
  seen.delegate->SetRenderSetting("refineEdgeLength", 8.0f);
  EXPECT_NEAR(triangles(), 2 * 7 * 7, 40);
  seen.delegate->SetRenderSetting("refineEdgeLength", 0.0f);
  EXPECT_EQ(triangles(), 8);  // refineLevel 1
  seen.delegate->SetRenderSetting("refineEdgeLength", Value());
  settings.settings["refineEdgeLength"] = 8.0f;
  seen.scene.SetRenderSettings("/settings_2", settings);
  EXPECT_NEAR(triangles(), 2 * 14 * 14, 100) << "the first settings prim";
  seen.delegate->SetRenderSetting("renderSettingsPrimPath", "/settings_2");
  EXPECT_NEAR(triangles(), 2 * 7 * 7, 40);
  seen.scene.Remove("/settings_2");
  seen.delegate->SetRenderSetting("renderSettingsPrimPath", Value());
  mesh.instancer = "/i";
  seen.scene.SetMesh("/square", mesh);
  host::InstancerDescription instancer;
  instancer.indices["/square"] = {0, 1};
  instancer.primvars["hydra:instanceTranslations"] = Array<Vec3f>{{0, 0, -200}, {0, 0, -2}};
  seen.scene.SetInstancer("/i", instancer);
  EXPECT_EQ(triangles(), 2 * 8 * 8) << "the nearest instance decides";
  seen.scene.Remove("/settings");
  seen.delegate->SetRenderSetting("refineEdgeLength", 4.0f);
  EXPECT_EQ(triangles(), 8);
  EXPECT_EQ(seen.count("settings.refineEdgeLength"), 1u);
}

TEST(NodeInputs, OneThatDoesNotFitIsReportedAndItsDefaultUsed) {
  MaterialNetwork network = displacing(grey("half.hdr", 0.5f));
  Seen plain, faulty;
  plain.scene.SetMaterial("/m", network);
  std::map<Token, Value>& texture = network.nodes["/m/texture"].parameters;
  texture["wrapS"] = Token("sideways"), texture["filter"] = 1.0f, texture["scale"] = 3.0f;
  texture["stScale"] = Vec2f(std::numeric_limits<float>::infinity(), 1), texture["stRotation"] = std::nan("");
  std::map<Token, Value>& displacement = network.nodes["/m/displacement"].parameters;
  displacement["midlevel"] = Token("high"), displacement["space"] = Token("moon");
  faulty.scene.SetMaterial("/m", network);
  for (Seen* seen : {&plain, &faulty}) seen->scene.SetMesh("/mesh", square());
  EXPECT_EQ(faulty.height(), plain.height());
  EXPECT_EQ(faulty.count("material.input"), 7u);
  EXPECT_EQ(plain.count("material.input"), 0u);
}

}  // namespace
}  // namespace alabaster::hd
