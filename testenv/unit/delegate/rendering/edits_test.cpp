// Edits while a thread of the delegate builds the scene, and while it is rendered.
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "testenv/support/stage.h"

namespace alabaster::hd {
namespace {

using std::chrono::milliseconds;

host::MeshDescription cube(int refine_level, float size = 1) {
  host::MeshDescription mesh;
  mesh.topology.scheme = "catmullClark";
  mesh.topology.faceVertexCounts = {4, 4, 4, 4, 4, 4};
  mesh.topology.faceVertexIndices = {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5};
  std::vector<Vec3f> points;
  for (int i = 0; i < 8; ++i) points.emplace_back(i & 1 ? size : -size, i & 2 ? size : -size, i & 4 ? size : -size);
  mesh.primvars["points"].value = Array<Vec3f>(std::move(points));
  mesh.displayStyle.refineLevel = refine_level;
  return mesh;
}

MaterialNetwork wax(float green) {
  MaterialNetwork network;
  MaterialNode& node = network.nodes["surface"];
  node.nodeTypeId = "AlabasterDisney";
  node.parameters["baseColor"] = Vec3f(0.8f, green, 0.5f);
  node.parameters["scatterDistance"] = Vec3f(0.1f);
  network.terminals["surface"] = {"surface", "surface"};
  return network;
}

// Leaves the scene as `step` says, whatever the steps before were.
void edit(host::RetainedSceneDelegate* scene, int step) {
  host::MeshDescription body = cube(3, 0.5f + 0.01f * static_cast<float>(step % 7));
  body.material = "/wax";
  body.transform[3][0] = 0.1 * (step % 5);
  scene->SetMesh("/body", body);
  scene->SetMaterial("/wax", wax(0.3f + 0.05f * static_cast<float>(step % 9)));
  host::LightDescription quad{.type = "rectLight", .transform = {}, .parameters = {{"intensity", 4.0f}}};
  quad.transform[3][0] = 0.2 * (step % 11), quad.transform[3][2] = 3;
  scene->SetLight("/quad_light", quad);
  if (step % 3 == 0) {
    scene->Remove("/extra");
  } else {
    host::MeshDescription extra = cube(step % 3, 0.3f);
    extra.transform[3][1] = 1;
    scene->SetMesh("/extra", extra);
  }
}

struct Drawn {
  explicit Drawn(int samples) : stage({{"samples", int64_t(samples)}, {"threads", 2}}) {
    stage.add_basic_scene();
    buffer = stage.add_buffer("/b", 24, 24, Format::float32vec4);
    stage.index->SyncAll();
    pass = stage.delegate->CreateRenderPass();
    state = Stage::state_for(24, 24, "color", buffer);
  }
  ~Drawn() { pass.reset(); }
  // Without waiting for the builder.
  double number() { return stage.delegate->GetRenderStats()["sceneNumber"].number_or(-1); }

  Stage stage;
  RenderBuffer* buffer = nullptr;
  std::unique_ptr<RenderPass> pass;
  RenderPassState state;
};

// The body's faces, but for those of /glow. A material that gives light and does not scatter.
void give_faces(host::RetainedSceneDelegate* scene, Array<int32_t> faces) {
  host::MeshDescription body = scene->GetMeshes().at("/body");
  body.topology.geomSubsets = {{"/body/part", "/glow", std::move(faces)}};
  scene->SetMesh("/body", body);
  MaterialNetwork glow;
  glow.nodes["surface"].nodeTypeId = "AlabasterDisney";
  glow.nodes["surface"].parameters["emission"] = Vec3f(0.2f, 0.6f, 1.0f);
  glow.terminals["surface"] = {"surface", "surface"};
  scene->SetMaterial("/glow", glow);
}

// promise: embedding.edit.subsets
TEST(Edits, EditedSubsetsBuildNoShapeAndGiveTheBytesOfAFreshDelegate) {
  Drawn edited(4), fresh(4);
  const auto draw = [](Drawn* drawn) {
    drawn->stage.index->SyncAll();
    EXPECT_TRUE(Stage::finish(*drawn->pass, drawn->state));
    return Stage::pixels<float>(drawn->buffer);
  };
  edit(&edited.stage.scene, 1);
  std::vector<std::vector<float>> pictures{draw(&edited)};
  const double refined = edited.stage.stat("sync.refineSeconds"), built = edited.stage.stat("sync.bvhSeconds");
  const std::vector<std::vector<int32_t>> parts{{0, 1, 2, 3, 4, 5}, {0, 2, 4}, {5}, {}};
  for (const auto& part : parts) {
    give_faces(&edited.stage.scene, Array<int32_t>(std::vector<int32_t>(part)));
    pictures.push_back(draw(&edited));
    EXPECT_NE(pictures.back(), pictures[pictures.size() - 2]);
  }
  EXPECT_EQ(pictures.back(), pictures.front()) << "a subset without faces";
  EXPECT_EQ(edited.stage.stat("sync.refineSeconds"), refined);
  EXPECT_EQ(edited.stage.stat("sync.bvhSeconds"), built);
  edit(&fresh.stage.scene, 1);
  give_faces(&fresh.stage.scene, Array<int32_t>(std::vector<int32_t>(parts[1])));
  EXPECT_EQ(draw(&fresh), pictures[2]);
}

// promise: embedding.edit.points
TEST(Edits, EditedPointsGiveTheBytesOfAFreshDelegate) {
  Drawn edited(4), fresh(4);
  const auto draw = [](Drawn* drawn, float size) {
    edit(&drawn->stage.scene, 1);
    host::MeshDescription body = drawn->stage.scene.GetMeshes().at("/body");
    body.displayStyle.refineLevel = 5;
    std::vector<Vec3f> points(body.primvars["points"].value.get<Array<Vec3f>>()->begin(),
                              body.primvars["points"].value.get<Array<Vec3f>>()->end());
    points[7] *= size;
    body.primvars["points"].value = Array<Vec3f>(std::move(points));
    drawn->stage.scene.SetMesh("/body", body);
    drawn->stage.index->SyncAll();
    EXPECT_TRUE(Stage::finish(*drawn->pass, drawn->state));
    return Stage::pixels<float>(drawn->buffer);
  };
  // The last but one has moved too far for the hierarchy to be kept.
  std::vector<float> last;
  for (const float size : {1.0f, 1.05f, 1.1f, 1.15f, 1.2f, 3.0f, 1.3f}) last = draw(&edited, size);
  EXPECT_EQ(last, draw(&fresh, 1.3f));
  EXPECT_EQ(edited.stage.dump(), fresh.stage.dump());
}

// The second hierarchy of a mesh is for the next edit alone.
// promise: embedding.edit.points
TEST(Edits, EditedPointsKeepSpareMemoryForTwoSecondsAtMost) {
  Drawn drawn(1 << 20);
  const auto shape = [&](int step) {
    host::MeshDescription body = cube(7, 0.5f + 0.01f * static_cast<float>(step));
    drawn.stage.scene.SetMesh("/body", body);
    drawn.stage.index->SyncAll();
    drawn.stage.wait_for_scene();
    drawn.pass->Execute(drawn.state);
    return drawn.stage.stat("memoryInUse");
  };
  const double once = shape(0);
  double edited = 0;
  for (int step = 1; step < 4; ++step) edited = std::max(edited, shape(step));
  constexpr double kSpare = 196608 * 40;  // less than a hierarchy of so many triangles
  EXPECT_GT(edited, once + kSpare);
  double rested = edited;
  for (int i = 0; i < 100 && rested > edited - kSpare; ++i) {
    std::this_thread::sleep_for(milliseconds(100));
    rested = drawn.stage.stat("memoryInUse");
  }
  EXPECT_LT(rested, edited - kSpare) << "once " << once << ", edited " << edited;
}

TEST(Edits, CommitAndExecuteDoNotWaitForTheBuild) {
  Drawn drawn(1);
  ASSERT_TRUE(Stage::finish(*drawn.pass, drawn.state));
  const double before = drawn.number();
  drawn.stage.scene.SetMesh("/heavy", cube(8));
  const auto start = std::chrono::steady_clock::now();
  drawn.stage.index->SyncAll();
  drawn.pass->Execute(drawn.state);
  const auto held = std::chrono::steady_clock::now() - start;
  EXPECT_EQ(drawn.number(), before) << "the scene of before";
  EXPECT_EQ(drawn.pass->GetState(), PassState::preparing);
  EXPECT_FALSE(drawn.pass->IsConverged()) << "of the scene of before";
  EXPECT_FALSE(drawn.buffer->IsConverged());
  drawn.stage.wait_for_scene();
  EXPECT_LT(held, (std::chrono::steady_clock::now() - start) / 3);
  EXPECT_GT(drawn.number(), before);
  EXPECT_TRUE(Stage::finish(*drawn.pass, drawn.state));
}

TEST(Edits, TheOldSceneIsRenderedDuringABuild) {
  Drawn drawn(1 << 20);
  drawn.pass->Execute(drawn.state);
  drawn.stage.wait_for_scene();
  drawn.pass->Execute(drawn.state);
  const double before = drawn.number();
  drawn.stage.scene.SetMesh("/heavy", cube(8));
  drawn.stage.index->SyncAll();
  drawn.pass->Execute(drawn.state);
  const auto samples = [&] { return drawn.stage.delegate->GetRenderStats()["numCompletedSamples"].number_or(0); };
  const double then = samples();
  for (int i = 0; i < 1000 && samples() <= then; ++i) std::this_thread::sleep_for(milliseconds(1));
  EXPECT_GT(samples(), then);
  EXPECT_EQ(drawn.number(), before) << "the mesh is refined still";
}

TEST(Edits, WaitForConvergenceTakesUpTheNewScene) {
  Drawn drawn(2);
  ASSERT_TRUE(Stage::finish(*drawn.pass, drawn.state));
  const auto before = Stage::pixels<float>(drawn.buffer);
  drawn.stage.scene.SetMesh("/quad", cube(6));
  drawn.stage.index->SyncAll();
  drawn.pass->Execute(drawn.state);
  EXPECT_TRUE(drawn.pass->WaitForConvergence(60));
  EXPECT_NE(Stage::pixels<float>(drawn.buffer), before);
}

// The first build is cancelled, the second one is not: of three edits two snapshots at most are seen.
// promise: embedding.edit.newer
TEST(Edits, ABuildThatIsCancelledIsNotPublished) {
  Drawn drawn(1);
  drawn.stage.wait_for_scene();
  const double before = drawn.number();
  drawn.stage.scene.SetMesh("/heavy", cube(8));
  drawn.stage.index->SyncAll();
  std::this_thread::sleep_for(milliseconds(20));
  drawn.stage.scene.Remove("/heavy");
  drawn.stage.scene.SetMesh("/quad", cube(1));
  drawn.stage.index->SyncAll();
  EXPECT_EQ(drawn.stage.stat("sceneNumber"), before + 1);
  EXPECT_EQ(drawn.stage.dump().find("/heavy"), std::string::npos);
}

// promise: embedding.edit.newer
TEST(Edits, AHostThatEditsWithoutEndSeesSnapshots) {
  Drawn drawn(1);
  drawn.stage.wait_for_scene();
  const double before = drawn.number();
  for (int step = 0; step < 20000 && drawn.number() < before + 3; ++step) {
    drawn.stage.scene.SetMesh("/body", cube(6, 1 + 0.001f * static_cast<float>(step)));
    drawn.stage.index->SyncAll();
    std::this_thread::sleep_for(milliseconds(1));
  }
  EXPECT_GE(drawn.number(), before + 3);
}

TEST(Edits, StopCancelsTheBuildAndRestartTakesItUp) {
  Drawn drawn(1);
  drawn.stage.wait_for_scene();
  const double before = drawn.number();
  drawn.stage.scene.SetMesh("/heavy", cube(8));
  drawn.stage.index->SyncAll();
  drawn.stage.delegate->Stop();
  std::this_thread::sleep_for(milliseconds(5));
  EXPECT_FALSE(drawn.stage.delegate->InvokeCommand("waitForScene", {}).value.get_or<bool>(true)) << "does not wait";
  EXPECT_EQ(drawn.number(), before);
  drawn.stage.delegate->Restart();
  EXPECT_TRUE(drawn.stage.delegate->InvokeCommand("waitForScene", {}).value.get_or<bool>(false));
  EXPECT_EQ(drawn.number(), before + 1);
  EXPECT_TRUE(Stage::finish(*drawn.pass, drawn.state));
}

// An image takes long to decode, which the host's thread does not wait for; one that a later edit replaces is not read.
TEST(Edits, FilesAreReadByTheBuilder) {
  Stage stage;
  stage.add_basic_scene();
  stage.index->SyncAll();
  stage.wait_for_scene();
  stage.delegate->Stop();  // and with it the builder
  host::MeshDescription waxen = Stage::quad();
  waxen.material = "/wax";
  stage.scene.SetMesh("/quad", waxen);
  for (const char* file : {"first.png", "second.png"}) {
    MaterialNetwork network = wax(0.5f);
    MaterialNode& texture = network.nodes["texture"];
    texture.nodeTypeId = "AlabasterTexture";
    texture.parameters["file"] = AssetPath{file, file, nullptr};
    network.nodes["surface"].inputConnections["baseColor"] = {{"texture", "rgb"}};
    stage.scene.SetMaterial("/wax", network);
    stage.index->SyncAll();
  }
  host::LightDescription dome{.type = "domeLight", .transform = {}, .parameters = {{"texture:file", "third.hdr"}}};
  stage.scene.SetLight("/dome", dome);
  stage.index->SyncAll();
  EXPECT_TRUE(stage.take_diagnostics().empty());
  stage.delegate->Restart();
  std::string errors;
  for (const Diagnostic& d : stage.take_diagnostics())
    if (d.severity == Severity::error) errors += d.where + ": " + d.text + "\n";
  EXPECT_EQ(errors.find("first.png"), std::string::npos) << errors;
  EXPECT_NE(errors.find("second.png"), std::string::npos) << errors;
  EXPECT_NE(errors.find("third.hdr"), std::string::npos) << errors;
  EXPECT_EQ(stage.stat("scene.faultCount"), 2);

  dome.transform[3][1] = 1;
  stage.scene.SetLight("/dome", dome);
  stage.index->SyncAll();
  EXPECT_TRUE(stage.take_diagnostics().empty()) << "a light that moves reads its files once";
  EXPECT_EQ(stage.stat("scene.faultCount"), 2);
  stage.scene.Remove("/wax");
  stage.scene.Remove("/dome");
  stage.index->SyncAll();
  EXPECT_EQ(stage.stat("scene.faultCount"), -1);
}

}  // namespace
}  // namespace alabaster::hd
