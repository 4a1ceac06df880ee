// The command tracePixel, and the stat that names a sample for it.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "testenv/support/stage.h"

namespace alabaster::hd {
namespace {

struct Frame {
  Stage stage{{{"samples", 2}}};
  std::unique_ptr<RenderPass> pass;
  RenderPassState state;

  Frame() {
    stage.add_basic_scene();
    RenderBuffer* buffer = stage.add_buffer("/b", 8, 8, Format::float32vec4);
    stage.index->SyncAll();
    pass = stage.delegate->CreateRenderPass();
    state = Stage::state_for(8, 8, "color", buffer);
  }
  CommandStatus status(const Dictionary& arguments) const {
    return stage.delegate->InvokeCommand("tracePixel", arguments).status;
  }
  std::string trace(const Dictionary& arguments) const {
    return stage.delegate->InvokeCommand("tracePixel", arguments).value.text_or("");
  }
};

TEST(TracePixel, AnswersForPixelsOfTheDataWindowAndWholeNumbers) {
  Frame f;
  EXPECT_EQ(f.status({{"x", 1}, {"y", 1}}), CommandStatus::failed) << "before the first frame";
  f.state.framing.dataWindow = {-2, 1, 6, 8};
  ASSERT_TRUE(Stage::finish(*f.pass, f.state));
  for (const Dictionary& good : std::vector<Dictionary>{{{"x", -2}, {"y", 1}},
                                                        {{"x", 5}, {"y", 7}},
                                                        {{"x", 5.0f}, {"y", int64_t(7)}, {"sample", 0}},
                                                        {{"x", 0}, {"y", 1}, {"sample", int64_t(4294967295)}}}) {
    const std::string pixel = "of pixel " + good.at("x").to_string() + "," + good.at("y").to_string() + ": colour (";
    EXPECT_NE(f.trace(good).find(pixel), std::string::npos) << f.trace(good);
  }
  for (const Dictionary& bad : std::vector<Dictionary>{{},
                                                       {{"x", 1}},
                                                       {{"x", 1}, {"y", "1"}},
                                                       {{"x", -3}, {"y", 1}},
                                                       {{"x", 6}, {"y", 1}},
                                                       {{"x", 1}, {"y", 0}},
                                                       {{"x", 1}, {"y", 8}},
                                                       {{"x", 1.5}, {"y", 1}},
                                                       {{"x", 1}, {"y", NAN}},
                                                       {{"x", 1}, {"y", 1e300}},
                                                       {{"x", 1}, {"y", 1}, {"sample", -1}},
                                                       {{"x", 1}, {"y", 1}, {"sample", 0.5}},
                                                       {{"x", 1}, {"y", 1}, {"sample", int64_t(4294967296)}},
                                                       {{"x", 1}, {"y", 1}, {"sample", "first"}}})
    EXPECT_EQ(f.status(bad), CommandStatus::invalid) << Value(std::make_shared<const Dictionary>(bad)).to_string();
}

// The quad, which pixels 2 to 5 of the display window see, shines as brightly as a float can, and a sky lights it.
TEST(TracePixel, TheStatNamesTheFirstSampleThatIsNotFinite) {
  Frame f;
  f.state.framing.displayMin = {1, 1};
  f.state.framing.displayMax = {9, 9};
  ASSERT_TRUE(Stage::finish(*f.pass, f.state));
  EXPECT_EQ(f.stage.text_stat("suspectSample"), "") << "every sample is finite";
  const Vec3f bright(std::numeric_limits<float>::max());
  f.stage.scene.SetLight("/dome", {.type = "domeLight", .transform = {}, .parameters = {{"color", bright}}});
  MaterialNetwork shining;
  shining.nodes["surface"] = {"AlabasterDisney", {{"emission", bright}}, {}};
  shining.terminals["surface"] = {"surface", "out"};
  f.stage.scene.SetMaterial("/shining", shining);
  host::MeshDescription quad = Stage::quad();
  quad.material = "/shining";
  f.stage.scene.SetMesh("/quad", quad);
  f.stage.index->SyncAll();
  ASSERT_TRUE(Stage::finish(*f.pass, f.state));
  EXPECT_EQ(f.stage.text_stat("suspectSample"), "2,2,0");
  EXPECT_NE(f.trace({{"x", 2}, {"y", 2}, {"sample", 0}}).find("not finite"), std::string::npos);
  EXPECT_EQ(f.pass->GetState(), PassState::converged) << "the render goes on";
}

}  // namespace
}  // namespace alabaster::hd
