// Meshes through Sync: diagnostics, and changes that must not cost a rebuild. The conformance suite has rows for the
// harm of faulty meshes, and core's cage_test for their codes.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <ctime>

#include "testenv/support/stage.h"

namespace alabaster::hd {
namespace {

TEST(MeshSync, SubsetsBindTheirMaterialsAndRebindingRefinesNothing) {
  Stage stage;
  host::MeshDescription mesh = Stage::quad();
  mesh.topology.faceVertexCounts = {3, 3};
  mesh.topology.faceVertexIndices = {0, 1, 2, 0, 2, 3};
  mesh.topology.geomSubsets = {{"/s0", "/red", {1}}, {"/s1", Path(), {0}}, {"/s2", "/green", {}}};
  mesh.material = "/grey";
  for (const char* name : {"/red", "/green", "/grey", "/blue"}) stage.scene.SetMaterial(name, {});
  stage.scene.SetMesh("/m", mesh);
  EXPECT_NE(stage.dump().find("  material 0 /grey\n  material 1 /red\n"), std::string::npos)
      << "subsets without material or faces take no slot";
  const double refined = stage.stat("sync.refineSeconds");
  mesh.topology.geomSubsets[0].materialId = "/blue";
  stage.scene.SetMesh("/m", mesh);
  EXPECT_NE(stage.dump().find("  material 0 /grey\n  material 1 /blue\n"), std::string::npos);
  EXPECT_EQ(stage.stat("sync.refineSeconds"), refined);
}

TEST(MeshSync, AScaleBeyondFloatIsReportedByName) {
  Stage stage;
  host::MeshDescription mesh = Stage::quad();
  mesh.transform.setScale(1e300);
  stage.scene.SetMesh("/huge", mesh);
  stage.index->SyncAll();
  ASSERT_EQ(stage.count("instance.transform"), 1u);
  for (const Diagnostic& d : stage.take_diagnostics()) {
    if (d.code == "instance.transform") {
      EXPECT_EQ(d.where, "/huge");
    }
  }
}

MaterialNetwork scattering() {
  MaterialNetwork network;
  MaterialNode node;
  node.nodeTypeId = "AlabasterDisney";
  node.parameters["scatterDistance"] = Vec3f(0.1f);
  network.nodes["/wax/surface"] = node;
  network.terminals["surface"].upstreamNode = "/wax/surface";
  return network;
}

TEST(MeshSync, SubsurfaceInAnOpenMeshIsReportedOnceForEachPrim) {
  Stage stage;
  stage.scene.SetMaterial("/wax", scattering());
  host::MeshDescription open = Stage::quad();
  stage.scene.SetMesh("/plain", open);
  open.material = "/wax";
  host::MeshDescription closed = open;
  closed.topology.faceVertexCounts = {3, 3, 3, 3};
  closed.topology.faceVertexIndices = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
  closed.primvars["points"].value = Array<Vec3f>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  stage.scene.SetMesh("/closed", closed);
  stage.index->SyncAll();
  EXPECT_EQ(stage.count("mesh.open"), 0u);
  stage.scene.SetMesh("/a", open);
  stage.index->SyncAll();
  ASSERT_EQ(stage.count("mesh.open"), 1u);
  stage.scene.SetMesh("/b", open);
  stage.index->SyncAll();
  std::vector<std::string> where;
  for (const Diagnostic& d : stage.take_diagnostics())
    if (d.code == "mesh.open") where.push_back(d.where);
  EXPECT_EQ(where, (std::vector<std::string>{"/a", "/b"}));
}

// Panes with an interior are reported. A face within a body has another remedy than a hole in it.
TEST(MeshSync, OpenMeshesOfClearMaterialsAreReportedWithTheirEdges) {
  Stage stage;
  const auto said = [&](const Dictionary& parameters, const host::MeshDescription& shape) {
    MaterialNetwork network = scattering();
    for (auto& [path, node] : network.nodes) node.parameters = {parameters.begin(), parameters.end()};
    stage.scene.SetMaterial("/m", network);
    host::MeshDescription mesh = shape;
    mesh.material = "/m";
    stage.scene.SetMesh("/a", mesh);
    stage.index->SyncAll();
    std::string text;
    for (const Diagnostic& d : stage.take_diagnostics())
      if (d.code == "mesh.open") text = d.text;
    return text;
  };
  host::MeshDescription walled = Stage::quad();
  walled.topology.faceVertexCounts = {3, 3, 3, 3, 3};
  walled.topology.faceVertexIndices = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3, 0, 1, 4};
  walled.primvars["points"].value = Array<Vec3f>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.25f, 0.25f, 0.25f}};
  const std::string pane = said({{"specTrans", 1.0f}}, Stage::quad());
  EXPECT_NE(pane.find("4 of its edges have one face, one from (-1, -1, 0)"), std::string::npos) << pane;
  EXPECT_NE(pane.find("make the material `thin`"), std::string::npos) << pane;
  const std::string wall = said({{"specTrans", 1.0f}}, walled);
  EXPECT_NE(wall.find("1 have three faces or another odd number, one from (0, 0, 0) to (1, 0, 0)"), std::string::npos)
      << wall;
  EXPECT_EQ(said({{"specTrans", 1.0f}, {"thin", true}}, Stage::quad()), "");
  EXPECT_EQ(said({{"diffTrans", 1.0f}}, Stage::quad()), "");
  EXPECT_NE(said({{"diffTrans", 1.0f}, {"attenuationDistance", 1.0f}}, Stage::quad()), "");
}

// A union is one body: one report, for its first open mesh.
TEST(MeshSync, SubsurfaceInASetOfOpenMeshesIsReportedOnce) {
  Stage stage;
  stage.scene.SetMaterial("/wax", scattering());
  host::MeshDescription open = Stage::quad(), closed = Stage::quad();
  open.material = closed.material = "/wax";
  closed.topology.faceVertexCounts = {3, 3, 3, 3};
  closed.topology.faceVertexIndices = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
  closed.primvars["points"].value = Array<Vec3f>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (host::MeshDescription* mesh : {&open, &closed})
    mesh->primvars["subsurfaceSet"] = {Interpolation::constant, {}, std::string("head"), {}};
  stage.scene.SetMesh("/a", closed);
  for (const char* name : {"/b", "/c", "/d"}) stage.scene.SetMesh(name, open);
  const auto said = [&] {
    stage.index->SyncAll();
    std::vector<std::string> texts;
    for (const Diagnostic& d : stage.take_diagnostics())
      if (d.code == "mesh.open") texts.push_back(d.where + ": " + d.text);
    return texts;
  };
  const std::vector<std::string> texts = said();
  ASSERT_EQ(texts.size(), 1u);
  EXPECT_EQ(texts[0].find("/b: "), 0u) << texts[0];
  EXPECT_NE(texts[0].find("4 of its edges have one face"), std::string::npos) << texts[0];
  EXPECT_NE(texts[0].find("2 other meshes of its subsurfaceSet are not closed either"), std::string::npos) << texts[0];
  stage.scene.SetLight("/dome", {.type = "domeLight", .transform = {}, .parameters = {}});
  EXPECT_TRUE(said().empty()) << "an edit of something else";
  stage.scene.SetMesh("/d", closed);
  EXPECT_EQ(said().size(), 1u) << "another report: one mesh less is open";
}

TEST(MeshSync, SheetsThatAreDoubledAreOpenForScatteringAndClearMaterials) {
  Stage stage;
  host::MeshDescription doubled = Stage::quad();
  doubled.topology.faceVertexCounts = {4, 4};
  doubled.topology.faceVertexIndices = {0, 1, 2, 3, 3, 2, 1, 0};
  doubled.material = "/wax";
  stage.scene.SetMaterial("/wax", scattering());
  stage.scene.SetMesh("/a", doubled);
  stage.index->SyncAll();
  EXPECT_EQ(stage.count("mesh.open"), 1u);
  MaterialNetwork clear = scattering();
  for (auto& [path, node] : clear.nodes) node.parameters = {{"specTrans", 1.0f}};
  stage.scene.SetMaterial("/glass", clear);
  doubled.material = "/glass";
  stage.scene.SetMesh("/b", doubled);
  stage.index->SyncAll();
  EXPECT_EQ(stage.count("mesh.open"), 2u);
}

// The winding of glass says where its interior is; walks find out by themselves.
TEST(MeshSync, TurnedFacesOfClearMaterialsAreReportedWithTheirEdges) {
  Stage stage;
  MaterialNetwork clear = scattering();
  for (auto& [path, node] : clear.nodes) node.parameters = {{"specTrans", 1.0f}};
  stage.scene.SetMaterial("/glass", clear);
  stage.scene.SetMaterial("/wax", scattering());
  host::MeshDescription closed = Stage::quad();
  closed.topology.faceVertexCounts = {3, 3, 3, 3};
  closed.topology.faceVertexIndices = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
  closed.primvars["points"].value = Array<Vec3f>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  closed.material = "/glass";
  stage.scene.SetMesh("/a", closed);
  stage.index->SyncAll();
  EXPECT_EQ(stage.count("mesh.winding"), 0u);
  closed.topology.faceVertexIndices = {0, 2, 1, 0, 1, 3, 1, 3, 2, 2, 0, 3};  // the slanted one
  stage.scene.SetMesh("/a", closed);
  stage.index->SyncAll();
  ASSERT_EQ(stage.count("mesh.winding"), 1u);
  for (const Diagnostic& d : stage.take_diagnostics())
    if (d.code == "mesh.winding") {
      EXPECT_NE(d.text.find("At 3 of its edges they run in one direction, one from (1, 0, 0)"), std::string::npos)
          << d.text;
    }
  closed.material = "/wax";
  stage.scene.SetMesh("/b", closed);
  stage.index->SyncAll();
  EXPECT_EQ(stage.count("mesh.winding"), 0u);
}

TEST(MeshSync, AnisotropyWithoutADirectionIsReportedOnceForEachPrim) {
  Stage stage;
  MaterialNetwork brushed;
  MaterialNode node;
  node.nodeTypeId = "AlabasterDisney";
  node.parameters["anisotropic"] = 0.8f;
  brushed.nodes["/brushed/surface"] = node;
  brushed.terminals["surface"].upstreamNode = "/brushed/surface";
  stage.scene.SetMaterial("/brushed", brushed);
  host::MeshDescription mesh = Stage::quad();
  mesh.primvars.erase("st");
  stage.scene.SetMesh("/plain", mesh);
  mesh.material = "/brushed";
  stage.scene.SetMesh("/without", mesh);
  mesh.primvars["st"] = {Interpolation::vertex, {}, Array<Vec2f>{{0, 0}, {1, 0}, {1, 1}, {0, 1}}, {}};
  stage.scene.SetMesh("/with", mesh);
  mesh.primvars["st"] = {Interpolation::vertex, {}, Array<Vec2f>{{0, 0}, {1, 0}, {1, 0}, {0, 0}}, {}};
  stage.scene.SetMesh("/without_area", mesh);
  stage.index->SyncAll();
  std::vector<std::string> where;
  for (const Diagnostic& d : stage.take_diagnostics())
    if (d.code == "mesh.direction") where.push_back(d.where);
  std::sort(where.begin(), where.end());
  EXPECT_EQ(where, (std::vector<std::string>{"/without", "/without_area"}));
}

// Wall time is a union, and CPU time is divided: meshes synced together never add up to more time than passed.
TEST(MeshSync, SecondsOfMeshesSyncedTogetherCountOnce) {
  Stage stage;
  host::MeshDescription mesh = Stage::quad();
  mesh.topology.scheme = "catmullClark";
  mesh.displayStyle.refineLevel = 6;
  for (int i = 0; i < 12; ++i) stage.scene.SetMesh(Path("/m" + std::to_string(i)), mesh);
  const auto start = std::chrono::steady_clock::now();
  const std::clock_t cpu = std::clock();  // of the process
  stage.index->SyncAll();
  stage.wait_for_scene();
  const double process = static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC;
  const double wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  for (const char* phase : {"sync.refine", "sync.bvh"}) {
    EXPECT_GT(stage.stat((phase + std::string("WallSeconds")).c_str()), 0) << phase;
    EXPECT_LE(stage.stat((phase + std::string("WallSeconds")).c_str()), wall) << phase;
    EXPECT_GT(stage.stat((phase + std::string("Seconds")).c_str()), 0) << phase;
  }
  constexpr double kTick = 2e-6;  // of std::clock
  EXPECT_LE(stage.stat("sync.refineSeconds") + stage.stat("sync.bvhSeconds"), process + kTick);
}

TEST(MeshSync, SubsurfaceSetsAreNamedOrByMaterial) {
  Stage stage;
  MaterialNetwork wax;
  wax.nodes["/wax/surface"] = {"AlabasterDisney", {{"scatterDistance", Vec3f(1, 1, 1)}}, {}};
  wax.terminals["surface"] = {"/wax/surface", "surface"};
  stage.scene.SetMaterial("/wax", wax);
  host::MeshDescription mesh = Stage::quad();
  mesh.material = "/wax";
  const auto dump_with = [&](host::PrimvarValue value) {
    mesh.primvars["subsurfaceSet"] = std::move(value);
    stage.scene.SetMesh("/m", mesh);
    return stage.dump();
  };
  EXPECT_NE(dump_with({Interpolation::constant, {}, Token("body"), {}}).find("subsurfaceSet named body\n"),
            std::string::npos);
  EXPECT_NE(
      stage.delegate->InvokeCommand("requirements", {}).value.text_or("").find("subsurface sets: yes (named body: 1 "),
      std::string::npos);
  EXPECT_NE(
      dump_with({Interpolation::constant, {}, std::string("byMaterial"), {}}).find("subsurfaceSet material /wax\n"),
      std::string::npos);
  EXPECT_EQ(stage.count("mesh.subsurfaceSet"), 0u);
  for (const host::PrimvarValue& wrong : {host::PrimvarValue{Interpolation::vertex, {}, Token("body"), {}},
                                          host::PrimvarValue{Interpolation::constant, {}, 3.0f, {}}})
    EXPECT_EQ(dump_with(wrong).find("subsurfaceSet"), std::string::npos);
  EXPECT_EQ(stage.count("mesh.subsurfaceSet"), 2u);
  // An object that does not scatter is in named sets alone.
  mesh.material = Path();
  EXPECT_EQ(dump_with({Interpolation::constant, {}, Token("byMaterial"), {}}).find("subsurfaceSet"), std::string::npos);
}

TEST(MeshSync, OptionsAreConstantFlags) {
  Stage stage;
  const auto dump_with = [&](const char* name, Interpolation interpolation, Value value) {
    host::MeshDescription mesh = Stage::quad();
    mesh.primvars[name] = {interpolation, {}, std::move(value), {}};
    stage.scene.SetMesh("/m", mesh);
    return stage.dump();
  };
  const std::string plain = dump_with("unread", Interpolation::constant, true);
  for (const auto& [name, otherwise, line] : {std::tuple("holdout", false, "  holdout true\n"),
                                              std::tuple("visibleToCamera", true, "  visibleToCamera false\n"),
                                              std::tuple("cryptoInstances", false, "  cryptoInstances true\n")}) {
    EXPECT_EQ(dump_with(name, Interpolation::constant, otherwise), plain);
    EXPECT_NE(dump_with(name, Interpolation::constant, !otherwise).find(line), std::string::npos);
    EXPECT_NE(dump_with(name, Interpolation::constant, otherwise ? 0.0f : 1.0f).find(line), std::string::npos);
    EXPECT_NE(dump_with(name, Interpolation::constant, Array<int32_t>{!otherwise}).find(line), std::string::npos);
    const std::string code = std::string("mesh.") + name;
    EXPECT_EQ(stage.count(code.c_str()), 0u);
    EXPECT_EQ(dump_with(name, Interpolation::vertex, !otherwise), plain);
    EXPECT_EQ(dump_with(name, Interpolation::constant, std::string("yes")), plain);
    EXPECT_EQ(stage.count(code.c_str()), 2u);
  }
}

TEST(MeshSync, OpenClearMeshesOfASetAreReportedOnce) {
  Stage stage;
  MaterialNetwork clear = scattering();
  for (auto& [path, node] : clear.nodes) node.parameters = {{"specTrans", 1.0f}};
  stage.scene.SetMaterial("/glass", clear);
  host::MeshDescription pane = Stage::quad();
  pane.material = "/glass";
  stage.scene.SetMesh("/alone", pane);
  const auto said = [&](const char* set) {
    for (const char* name : {"/b", "/c", "/d"}) {
      pane.primvars["subsurfaceSet"] = {Interpolation::constant, {}, std::string(set), {}};
      stage.scene.SetMesh(name, pane);
    }
    stage.index->SyncAll();
    std::vector<std::string> texts;
    for (const Diagnostic& d : stage.take_diagnostics())
      if (d.code == "mesh.open") texts.push_back(d.where + ": " + d.text);
    return texts;
  };
  for (const char* set : {"window", "byMaterial"}) {
    std::vector<std::string> texts = said(set);
    std::erase_if(texts, [](const std::string& text) { return text.starts_with("/alone: "); });
    ASSERT_EQ(texts.size(), set == std::string("window") ? 1u : 0u) << set << ": the same report is not repeated";
    for (const std::string& text : texts) {
      EXPECT_EQ(text.find("/b: a clear material"), 0u) << text;
      EXPECT_NE(text.find("2 other meshes of its subsurfaceSet are not closed either"), std::string::npos) << text;
    }
  }
  EXPECT_EQ(said("").size(), 3u) << "each for itself";
}

}  // namespace
}  // namespace alabaster::hd
