// Meshes of equal geometry are built once, whatever their materials are, and pictures do not show it.
#include <gtest/gtest.h>

#include "testenv/support/stage.h"

namespace alabaster::hd {
namespace {

MaterialNetwork colored(float red, float scatter = 0) {
  MaterialNetwork network;
  MaterialNode& node = network.nodes["surface"];
  node.nodeTypeId = "AlabasterDisney";
  node.parameters["baseColor"] = Vec3f(red, 0.5f, 0.3f);
  if (scatter > 0) node.parameters["scatterDistance"] = Vec3f(scatter);
  network.terminals["surface"] = {"surface", "surface"};
  return network;
}

/// A subdivided cube; each call makes arrays of its own.
host::MeshDescription cube(const char* material, double x, float corner = 1) {
  host::MeshDescription mesh;
  mesh.topology.scheme = "catmullClark";
  mesh.topology.faceVertexCounts = {4, 4, 4, 4, 4, 4};
  mesh.topology.faceVertexIndices = {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5};
  std::vector<Vec3f> points;
  for (int i = 0; i < 8; ++i) points.emplace_back(i & 1 ? corner : -1.f, i & 2 ? 1.f : -1.f, i & 4 ? 1.f : -1.f);
  mesh.primvars["points"].value = Array<Vec3f>(std::move(points));
  mesh.displayStyle.refineLevel = 4;
  mesh.material = material;
  mesh.transform.setScale(0.4);
  mesh.transform[3][0] = x;
  return mesh;
}

class EqualMeshes : public ::testing::Test {
 protected:
  void SetUp() override {
    stage_.add_basic_scene();
    stage_.scene.Remove("/quad");
    for (const auto& [name, red] : {std::pair("/red", 0.9f), std::pair("/grey", 0.4f), std::pair("/wax", 0.7f)})
      stage_.scene.SetMaterial(name, colored(red, std::string(name) == "/wax" ? 0.1f : 0));
  }
  /// How many meshes the renderer holds.
  static int built(Stage& stage) {
    stage.index->SyncAll();
    stage.wait_for_scene();
    const std::string text = stage.delegate->InvokeCommand("requirements", {}).value.text_or("");
    const size_t of = text.find(" of ", text.find("instances: "));
    return of == std::string::npos ? -1 : std::atoi(text.c_str() + of + 4);
  }
  int built() { return built(stage_); }
  std::vector<float> picture(Stage& stage) {
    RenderBuffer* buffer = stage.add_buffer("/buffer", 24, 24, Format::float32vec4);
    stage.index->SyncAll();
    auto pass = stage.delegate->CreateRenderPass();
    EXPECT_TRUE(Stage::finish(*pass, Stage::state_for(24, 24, "color", buffer)));
    return Stage::pixels<float>(buffer);
  }

  Stage stage_{{{"samples", int64_t(4)}, {"threads", 2}}};
};

TEST_F(EqualMeshes, MaterialsAndSubsetsOfEqualMeshesAreTheirOwn) {
  stage_.scene.SetMesh("/a", cube("/red", -0.6));
  stage_.scene.SetMesh("/b", cube("/grey", 0));
  host::MeshDescription parted = cube("/red", 0.6);
  parted.topology.geomSubsets = {{"/top", "/wax", {0, 3}}};
  stage_.scene.SetMesh("/c", parted);
  EXPECT_EQ(built(), 1);
  const std::vector<float> shared = picture(stage_);
  // Points that differ in one bit of a place that shows nowhere: three meshes.
  Stage apart{{{"samples", int64_t(4)}, {"threads", 2}}};
  apart.add_basic_scene();
  apart.scene.Remove("/quad");
  for (const auto& [name, red] : {std::pair("/red", 0.9f), std::pair("/grey", 0.4f), std::pair("/wax", 0.7f)})
    apart.scene.SetMaterial(name, colored(red, std::string(name) == "/wax" ? 0.1f : 0));
  int number = 0;
  for (auto mesh : {cube("/red", -0.6), cube("/grey", 0), parted}) {
    mesh.subdivTags.cornerIndices = {number}, mesh.subdivTags.cornerWeights = {0.0f};
    apart.scene.SetMesh(std::string(1, '/') + char('a' + number++), mesh);
  }
  EXPECT_EQ(picture(apart), shared);
  EXPECT_EQ(built(apart), 3);
}

TEST_F(EqualMeshes, AnEditOfOneLeavesTheOther) {
  stage_.scene.SetMesh("/a", cube("/red", -0.6));
  stage_.scene.SetMesh("/b", cube("/grey", 0.6));
  EXPECT_EQ(built(), 1);
  const std::vector<float> before = picture(stage_);
  for (const float corner : {1.5f, 1.25f, 1.5f}) {
    stage_.scene.SetMesh("/a", cube("/red", -0.6, corner));
    EXPECT_EQ(built(), 2);
  }
  EXPECT_NE(picture(stage_), before);
  stage_.scene.Remove("/a");
  EXPECT_EQ(built(), 1);
  stage_.scene.SetMesh("/a", cube("/red", -0.6));
  EXPECT_EQ(built(), 1);
  EXPECT_EQ(picture(stage_), before);
}

TEST_F(EqualMeshes, OtherBitsOptionsOrPrimvarsMakeAnotherMesh) {
  stage_.scene.SetMesh("/a", cube("/red", 0));
  auto zero = cube("/red", 0), level = cube("/red", 0), uvs = cube("/red", 0), hole = cube("/red", 0);
  zero.primvars["points"].value = Array<Vec3f>{{-1, -1, -1}, {1, -1, -1}, {-1, 1, -1}, {1, 1, -1},
                                               {-1, -1, 1},  {1, -1, 1},  {-1, 1, 1},  {1, 1, 1.5f}};
  level.displayStyle.refineLevel = 3;
  uvs.primvars["st"] = {Interpolation::vertex, "textureCoordinate", Array<Vec2f>(std::vector<Vec2f>(8)), {}};
  hole.topology.holeIndices = {2};
  int number = 1;
  for (const auto& mesh : {zero, level, uvs, hole}) {
    stage_.scene.SetMesh("/b", mesh);
    EXPECT_EQ(built(), 2) << number++;
  }
}

// A report names its mesh, so each mesh has its own.
TEST_F(EqualMeshes, FaultsAreReportedForEachMesh) {
  for (const char* name : {"/a", "/b", "/c"}) {
    host::MeshDescription mesh = cube("/red", 0);
    mesh.topology.faceVertexIndices = {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 99};
    stage_.scene.SetMesh(name, mesh);
  }
  stage_.index->SyncAll();
  std::vector<std::string> named;
  for (const Diagnostic& d : stage_.take_diagnostics())
    if (d.code.starts_with("mesh.")) named.push_back(d.where);
  std::sort(named.begin(), named.end());
  EXPECT_EQ(named, (std::vector<std::string>{"/a", "/b", "/c"}));
}

}  // namespace
}  // namespace alabaster::hd
