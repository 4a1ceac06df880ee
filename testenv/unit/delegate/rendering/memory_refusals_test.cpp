// A scene that the memory limit refuses: one report, and the last picture stays.
#include <gtest/gtest.h>

#include <numeric>

#include "testenv/support/drawing.h"

namespace alabaster::hd {
namespace {

constexpr double kOneMiB = 1 << 20;

void add_wax_cube(Stage* stage, int level) {
  host::MeshDescription mesh = Stage::cube(level);
  mesh.material = "/wax";
  stage->scene.SetMesh("/cube", mesh);
  stage->set_surface("/wax", {});
}

// promise: pipeline.memory.refusal
TEST(MemoryRefusals, ABodyIsRefusedOnceAndThePictureStays) {
  Drawing drawing(256);
  Stage& stage = drawing.stage;
  add_wax_cube(&stage, 6);
  ASSERT_TRUE(drawing.draw());
  ASSERT_EQ(drawing.errors(), "");
  auto* const buffer = static_cast<RenderBuffer*>(stage.index->GetBprim("/color"));
  const std::vector<float> picture = Stage::pixels<float>(buffer);
  const double number = stage.stat("sceneNumber");
  // Too little for the shells of a mesh that scatters.
  stage.delegate->SetRenderSetting("memoryLimit", static_cast<int64_t>(stage.stat("memoryInUse") / kOneMiB + 2));
  stage.set_surface("/wax", {{"scatterDistance", Vec3f(9, 9, 9)}});
  EXPECT_FALSE(drawing.draw());
  EXPECT_EQ(stage.stat("scene.outOfMemory"), 1);
  EXPECT_EQ(stage.count("scene.memory"), 1u);
  const std::string errors = drawing.errors();
  EXPECT_EQ(errors.find("/cube: the interior of a mesh of "), 0u) << errors;
  EXPECT_NE(errors.find("raise memoryLimit, or lower refineLevel"), std::string::npos) << errors;
  EXPECT_EQ(std::count(errors.begin(), errors.end(), '\n'), 2) << "and that of the pass: " << errors;
  for (int i = 0; i < 3; ++i) {
    EXPECT_FALSE(drawing.draw());
    EXPECT_EQ(Stage::pixels<float>(buffer), picture);
    EXPECT_EQ(drawing.errors(), "");
  }
  stage.delegate->SetRenderSetting("memoryLimit", 256);
  ASSERT_TRUE(drawing.draw());
  EXPECT_GT(stage.stat("sceneNumber"), number);
  EXPECT_EQ(stage.stat("scene.faultCount"), -1) << stage.text_stat("scene.faults");
  EXPECT_EQ(drawing.errors(), "");
}

/// Twenty thousand quads that emit, which are not an array: their hierarchy takes megabytes.
void add_many(Stage& stage) {
  host::InstancerDescription instancer;
  std::vector<Vec3f> places;
  for (int i = 0; i < 20000; ++i) places.emplace_back(0, 0, -float(i));
  instancer.primvars = {{"hydra:instanceTranslations", Array<Vec3f>(places)}};
  std::vector<int32_t> indices(places.size());
  std::iota(indices.begin(), indices.end(), 0);
  instancer.indices["/many"] = indices;
  host::MeshDescription mesh = Stage::quad();
  mesh.instancer = "/instancer";
  mesh.material = "/glow";
  stage.set_surface("/glow", {{"emission", Vec3f(1, 1, 1)}});
  stage.scene.SetInstancer("/instancer", instancer);
  stage.scene.SetMesh("/many", mesh);
}

// The hierarchy of all instances is of no prim.
// promise: pipeline.memory.refusal
TEST(MemoryRefusals, TheLastPictureStaysWhileTheSceneAsAWholeIsRefused) {
  Drawing drawing(256);
  Stage& stage = drawing.stage;
  auto* const buffer = static_cast<RenderBuffer*>(stage.index->GetBprim("/color"));
  ASSERT_TRUE(drawing.draw());
  const std::vector<float> picture = Stage::pixels<float>(buffer);
  add_many(stage);
  int refused = 0;
  for (int mib = 2; mib < 64 && refused < 2; ++mib) {
    stage.delegate->SetRenderSetting("memoryLimit", mib);
    drawing.draw();
    if (drawing.pass->GetState() != PassState::failed) continue;
    ++refused;
    EXPECT_EQ(Stage::pixels<float>(buffer), picture);
    EXPECT_EQ(stage.stat("scene.outOfMemory"), 1);
  }
  EXPECT_EQ(refused, 2);
  EXPECT_GE(stage.count("scene.memory"), 1u);
  const std::string errors = drawing.errors();
  EXPECT_NE(errors.find("the next commit builds it again"), std::string::npos) << errors;
  EXPECT_NE(errors.find("raise memoryLimit"), std::string::npos) << errors;
  stage.delegate->SetRenderSetting("memoryLimit", 256);
  EXPECT_TRUE(drawing.draw());
  EXPECT_EQ(stage.stat("scene.faultCount"), -1) << stage.text_stat("scene.faults");
  EXPECT_NE(Stage::pixels<float>(buffer), picture);
}

}  // namespace
}  // namespace alabaster::hd
