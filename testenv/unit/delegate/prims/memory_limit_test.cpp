// The memory limit inside a host: errors name who asks for more, and the delegate goes on.
#include <gtest/gtest.h>

#include "testenv/support/stage.h"

namespace alabaster::hd {
namespace {

constexpr double kMiB = 1 << 20;

/// Drawn as a cage of one face: 2 * 4^level triangles.
host::MeshDescription refined_quad(int level) {
  host::MeshDescription mesh = Stage::quad();
  mesh.topology.scheme = "catmullClark";
  mesh.displayStyle.refineLevel = level;
  return mesh;
}

/// A pass over the basic scene.
struct Drawing {
  explicit Drawing(int mib) : stage({{"memoryLimit", mib}, {"samples", 1}}) {
    stage.add_basic_scene();
    RenderBuffer* const buffer = stage.add_buffer("/color", 8, 8, Format::float32vec4);
    state = Stage::state_for(8, 8, "color", buffer);
    stage.index->SyncAll();
    pass = stage.delegate->CreateRenderPass();
  }
  bool draw() {
    stage.index->SyncAll();
    return Stage::finish(*pass, state) && pass->GetState() == PassState::converged;
  }
  std::string errors() {
    std::string all;
    for (const Diagnostic& d : stage.take_diagnostics())
      if (d.severity == Severity::error) all += d.where + ": " + d.text + "\n";
    return all;
  }
  Stage stage;
  RenderPassState state;
  std::unique_ptr<RenderPass> pass;
};

TEST(MemoryLimit, AMeshThatItDoesNotHoldIsNamedAndTheDelegateGoesOnWithoutIt) {
  Drawing drawing(16);
  ASSERT_TRUE(drawing.draw()) << drawing.errors();
  const double before = drawing.stage.stat("memoryInUse");
  EXPECT_GT(before, 0);
  drawing.stage.scene.SetMesh("/fine", refined_quad(8));
  EXPECT_TRUE(drawing.draw()) << "the rest of the scene";
  const std::string errors = drawing.errors();
  EXPECT_NE(errors.find("/fine: a mesh of 131072 triangles needs "), std::string::npos) << errors;
  EXPECT_NE(errors.find("of the memory limit of 16 MiB"), std::string::npos) << errors;
  EXPECT_NE(errors.find("lower refineLevel"), std::string::npos) << errors;
  EXPECT_EQ(drawing.stage.stat("scene.faultCount"), 1);
  EXPECT_EQ(drawing.stage.stat("scene.outOfMemory"), 1);
  drawing.stage.scene.Remove("/fine");
  EXPECT_TRUE(drawing.draw());
  EXPECT_EQ(drawing.errors(), "");
  EXPECT_EQ(drawing.stage.stat("scene.faultCount"), -1);
  EXPECT_LT(drawing.stage.stat("memoryInUse"), before + kMiB / 2) << "all of it was given back";
}

TEST(MemoryLimit, ALimitThatIsRaisedHasTheNextCommitBuildWhatWasRefused) {
  Drawing drawing(16);
  drawing.stage.scene.SetMesh("/fine", refined_quad(8));
  ASSERT_TRUE(drawing.draw());
  EXPECT_NE(drawing.errors(), "");
  drawing.stage.delegate->SetRenderSetting("memoryLimit", 1024);
  EXPECT_TRUE(drawing.draw());
  EXPECT_EQ(drawing.errors(), "");
  EXPECT_EQ(drawing.stage.stat("scene.faultCount"), -1);
  EXPECT_GT(drawing.stage.stat("memoryInUse"), 10 * kMiB);
}

TEST(MemoryLimit, DelegatesHaveOneEach) {
  Drawing small(16), large(1024);
  for (Drawing* drawing : {&small, &large}) {
    drawing->stage.scene.SetMesh("/fine", refined_quad(8));
    ASSERT_TRUE(drawing->draw());
  }
  EXPECT_NE(small.errors(), "");
  EXPECT_EQ(large.errors(), "");
  EXPECT_LT(small.stage.stat("memoryInUse"), 16 * kMiB);
}

TEST(MemoryLimit, EditsGiveBackWhatTheyReplace) {
  Drawing drawing(64);
  const auto edit = [&](int step) {
    host::MeshDescription mesh = refined_quad(6);
    mesh.primvars["points"].value = Array<Vec3f>{{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, float(step) / 100}};
    drawing.stage.scene.SetMesh("/fine", mesh);
    EXPECT_TRUE(drawing.draw()) << step;
    return drawing.stage.stat("memoryInUse");
  };
  const double first = edit(1);
  double last = 0;
  for (int step = 2; step < 40; ++step) last = edit(step);
  EXPECT_EQ(drawing.errors(), "");
  EXPECT_LT(last, 4 * first) << "the scene of before may still be there, and the one that a pass lets go of";
}

/// A grey image of a million texels, as halves, in a material for each of these wrap modes.
void add_images(Stage& stage, const std::vector<const char*>& wraps) {
  std::string text = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 262144 +X 4\n";
  text.append(size_t(4) << 20, '\x80');
  const AssetPath file{"tall.hdr", "tall.hdr", std::make_shared<const std::vector<uint8_t>>(text.begin(), text.end())};
  for (const char* wrap : wraps) {
    MaterialNetwork network;
    network.nodes["/m/surface"] = {"AlabasterDisney", {}, {{"baseColor", {{"/m/map", "rgb"}}}}};
    network.nodes["/m/map"] = {"AlabasterTexture", {{"file", file}, {"wrapS", std::string(wrap)}}, {}};
    network.terminals["surface"] = {"/m/surface", "surface"};
    const std::string name = wrap;
    stage.scene.SetMaterial("/" + name, network);
    host::MeshDescription mesh = Stage::quad();
    mesh.material = "/" + name;
    stage.scene.SetMesh("/mesh_" + name, mesh);
  }
}

TEST(MemoryLimit, AnImageIsHeldOnceWhateverItsWrapModes) {
  Drawing one(256), three(256);
  add_images(one.stage, {"repeat"});
  add_images(three.stage, {"repeat", "clamp", "mirror"});
  ASSERT_TRUE(one.draw() && three.draw());
  EXPECT_GT(one.stage.stat("memoryInUse"), 2 * kMiB);
  EXPECT_LT(three.stage.stat("memoryInUse"), one.stage.stat("memoryInUse") + kMiB);
  EXPECT_LT(three.stage.stat("totalMemory"), one.stage.stat("totalMemory") + kMiB);
}

TEST(MemoryLimit, AnImageIsDecodedOnceAVisibleMeshHasItsMaterial) {
  Drawing drawing(256);
  add_images(drawing.stage, {"repeat"});
  host::MeshDescription mesh = drawing.stage.scene.GetMeshes().at("/mesh_repeat");
  mesh.visible = false;
  drawing.stage.scene.SetMesh("/mesh_repeat", mesh);
  ASSERT_TRUE(drawing.draw());
  const double before = drawing.stage.stat("memoryInUse");
  EXPECT_LT(before, kMiB);
  mesh.visible = true;
  drawing.stage.scene.SetMesh("/mesh_repeat", mesh);
  ASSERT_TRUE(drawing.draw());
  EXPECT_GT(drawing.stage.stat("memoryInUse"), before + 2 * kMiB);
}

TEST(MemoryLimit, AnImageThatItDoesNotHoldIsRefusedBeforeItIsDecoded) {
  Drawing drawing(5);
  add_images(drawing.stage, {"repeat"});
  drawing.stage.index->SyncAll();
  const std::string errors = drawing.errors();
  EXPECT_NE(errors.find("tall.hdr: an image of 4 x 262144 pixels needs 6 MiB more"), std::string::npos) << errors;
  EXPECT_EQ(drawing.stage.stat("scene.outOfMemory"), 1);
}

// A header is enough: rows of this length are not read.
TEST(MemoryLimit, AnImageOfLongRowsIsRefusedBeforeARowIsRead) {
  Drawing drawing(64);
  const std::string text = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 8388608\n";
  const AssetPath file{"wide.hdr", "wide.hdr", std::make_shared<const std::vector<uint8_t>>(text.begin(), text.end())};
  drawing.stage.scene.SetLight("/dome", {.type = "domeLight", .transform = {}, .parameters = {{"texture:file", file}}});
  drawing.stage.index->SyncAll();
  const std::string errors = drawing.errors();
  EXPECT_NE(errors.find("wide.hdr: decoding an image of 8388608 pixels a row needs "), std::string::npos) << errors;
  EXPECT_EQ(drawing.stage.stat("scene.outOfMemory"), 1);
}

TEST(MemoryLimit, FramesCountForAsLongAsTheyAreDrawn) {
  Drawing drawing(64);
  ASSERT_TRUE(drawing.draw());
  const double before = drawing.stage.stat("memoryInUse");
  RenderBuffer* const large = drawing.stage.add_buffer("/large", 512, 512, Format::float32vec4);
  drawing.state = Stage::state_for(512, 512, "color", large);
  ASSERT_TRUE(drawing.draw());
  EXPECT_GT(drawing.stage.stat("memoryInUse"), before + 512 * 512 * 36);
  drawing.pass = nullptr;
  EXPECT_LE(drawing.stage.stat("memoryInUse"), before);
}

}  // namespace
}  // namespace alabaster::hd
