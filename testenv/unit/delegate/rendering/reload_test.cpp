// Images that are edited on disk, and faults that come, go and return.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "testenv/support/stage.h"

namespace alabaster::hd {
namespace {

class Reload : public ::testing::Test {
 protected:
  Reload() : folder(std::filesystem::temp_directory_path() / ("reload_test_" + std::to_string(getpid()))) {
    std::filesystem::create_directory(folder);
    stage.add_basic_scene();
    pass = stage.delegate->CreateRenderPass();
    buffer = stage.add_buffer("/b", 4, 4, Format::float32vec4);
  }
  ~Reload() override {
    pass.reset();
    std::filesystem::remove_all(folder);
  }
  // A Radiance picture of one colour.
  std::string write(const std::string& name, int red, int green, int blue) const {
    const std::string file = folder / name;
    std::ofstream out(file, std::ios::binary);
    out << "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 2\n";
    for (int i = 0; i < 4; ++i) out << char(red / 2) << char(green / 2) << char(blue / 2) << char(129);
    return file;
  }
  static MaterialNetwork textured(const std::string& file) {
    MaterialNetwork network;
    network.nodes["surface"] = {"AlabasterDisney", {}, {{"baseColor", {{"image", "rgb"}}}}};
    network.nodes["image"] = {"AlabasterTexture", {{"file", AssetPath{file, file, nullptr}}}, {}};
    network.terminals["surface"] = {"surface", "out"};
    return network;
  }
  std::vector<float> draw() {
    EXPECT_TRUE(Stage::finish(*pass, Stage::state_for(4, 4, "color", buffer)));
    return Stage::pixels<float>(buffer);
  }
  std::string command(const char* name, const Dictionary& arguments = {}) const {
    const CommandResult result = stage.delegate->InvokeCommand(name, arguments);
    return result.ok() ? std::string() : result.fault.empty() ? "no reason" : result.fault;
  }
  static bool is_red(const std::vector<float>& p) { return p[4 * 5] > 2 * p[4 * 5 + 2]; }
  static bool is_blue(const std::vector<float>& p) { return p[4 * 5 + 2] > 2 * p[4 * 5]; }

  Stage stage{{{"samples", int64_t(16)}}};
  std::unique_ptr<RenderPass> pass;
  RenderBuffer* buffer = nullptr;
  std::filesystem::path folder;
};

TEST_F(Reload, AnEditedImageIsReadAgain) {
  const std::string file = write("a.hdr", 255, 0, 0), other = write("b.hdr", 255, 0, 0);
  stage.scene.SetMaterial("/material", textured(file));
  stage.scene.SetMaterial("/same", textured(file));
  host::MeshDescription quad = Stage::quad();
  quad.material = "/material";
  stage.scene.SetMesh("/quad", quad);
  stage.index->SyncAll();
  const auto red = draw();
  EXPECT_TRUE(is_red(red));
  write("a.hdr", 0, 0, 255);
  EXPECT_EQ(draw(), red) << "nobody said so";
  EXPECT_EQ(command("reloadResource", {{"file", other}}), "");
  EXPECT_EQ(draw(), red) << "another file";
  EXPECT_EQ(command("reloadResource", {{"file", file}}), "");
  EXPECT_TRUE(is_blue(draw()));
  write("a.hdr", 255, 0, 0);
  EXPECT_EQ(command("flush"), "");
  EXPECT_EQ(draw(), red);
  EXPECT_NE(command("reloadResource"), "") << "which?";
  // A material that is edited later shows the image as it is now.
  write("a.hdr", 0, 0, 255);
  command("reloadResource", {{"file", file}});
  MaterialNetwork rough = textured(file);
  rough.nodes["surface"].parameters["roughness"] = 1.0f;
  stage.scene.SetMaterial("/material", rough);
  stage.index->SyncAll();
  EXPECT_TRUE(is_blue(draw()));
  // Those that are gone are not asked.
  stage.scene.Remove("/material");
  stage.scene.Remove("/same");
  EXPECT_EQ(command("flush"), "");
}

TEST_F(Reload, AMissingImageAppears) {
  const std::string file = folder / "later.hdr";
  stage.scene.SetMaterial("/material", textured(file));
  host::MeshDescription quad = Stage::quad();
  quad.material = "/material";
  stage.scene.SetMesh("/quad", quad);
  stage.index->SyncAll();
  draw();
  EXPECT_EQ(stage.stat("scene.faultCount"), 1);
  write("later.hdr", 255, 0, 0);
  EXPECT_EQ(command("reloadResource", {{"file", file}}), "");
  EXPECT_TRUE(is_red(draw()));
  EXPECT_EQ(stage.stat("scene.faultCount"), -1) << "the scene is whole";
}

TEST_F(Reload, OneOfASetAndALightsImage) {
  write("set.1001.hdr", 255, 0, 0);
  stage.scene.SetMaterial("/material", textured(folder / "set.<UDIM>.hdr"));
  host::MeshDescription quad = Stage::quad();
  quad.material = "/material";
  quad.primvars["st"].value = Array<Vec2f>{{0.1f, 0.1f}, {0.9f, 0.1f}, {0.9f, 0.9f}, {0.1f, 0.9f}};
  stage.scene.SetMesh("/quad", quad);
  stage.index->SyncAll();
  EXPECT_TRUE(is_red(draw()));
  const std::string one = write("set.1001.hdr", 0, 0, 255);
  EXPECT_EQ(command("reloadResource", {{"file", one}}), "");
  EXPECT_TRUE(is_blue(draw()));

  stage.scene.Remove("/material");
  const std::string sky = write("sky.hdr", 0, 0, 255);
  host::LightDescription dome{.type = "domeLight", .transform = {}, .parameters = {}};
  dome.parameters["texture:file"] = AssetPath{sky, sky, nullptr};
  stage.scene.SetLight("/dome", dome);
  stage.index->SyncAll();
  EXPECT_TRUE(is_blue(draw()));
  write("sky.hdr", 255, 0, 0);
  EXPECT_EQ(command("reloadResource", {{"file", sky}}), "");
  EXPECT_TRUE(is_red(draw()));
}

// A fault is said once, and again when it returns: a panel lists it.
TEST_F(Reload, AFaultIsSaidOnceAndAgainWhenItReturns) {
  const auto said = [&](const char* code) {
    stage.index->SyncAll();
    const size_t count = stage.count(code);
    stage.take_diagnostics();
    return count;
  };
  MaterialNetwork unknown;
  unknown.nodes["n"] = {"FancyShader", {}, {}};
  unknown.terminals["surface"] = {"n", "out"};
  MaterialNetwork known = unknown;
  known.nodes["n"].nodeTypeId = "AlabasterDisney";
  stage.scene.SetMaterial("/material", unknown);
  EXPECT_EQ(said("material.node"), 1u);
  unknown.nodes["n"].parameters["gain"] = 0.5f;
  stage.scene.SetMaterial("/material", unknown);
  EXPECT_EQ(said("material.node"), 0u) << "an edit of the same unknown node";
  stage.scene.SetMaterial("/material", known);
  EXPECT_EQ(said("material.node"), 0u);
  stage.scene.SetMaterial("/material", unknown);
  EXPECT_EQ(said("material.node"), 1u) << "it returned";

  host::MeshDescription quad = Stage::quad();
  quad.material = "/nowhere";
  stage.scene.SetMesh("/quad", quad);
  EXPECT_EQ(said("mesh.material"), 1u);
  quad.transform[3][0] = 0.1;
  stage.scene.SetMesh("/quad", quad);
  EXPECT_EQ(said("mesh.material"), 0u);
  quad.material = "/material";
  stage.scene.SetMesh("/quad", quad);
  EXPECT_EQ(said("mesh.material"), 0u);
  quad.material = "/nowhere";
  stage.scene.SetMesh("/quad", quad);
  EXPECT_EQ(said("mesh.material"), 1u) << "it returned";

  quad.primvars["normals"].value = Array<Vec3f>{{0, 0, 1}};
  stage.scene.SetMesh("/quad", quad);
  EXPECT_EQ(said("mesh.normals.size"), 1u);
  quad.primvars["points"].value = Array<Vec3f>{{-1, -1, 0}, {1, -1, 0}, {1, 1, 0.5f}, {-1, 1, 0}};
  stage.scene.SetMesh("/quad", quad);
  EXPECT_EQ(said("mesh.normals.size"), 0u) << "another shape with the same fault";
  quad.primvars.erase("normals");
  stage.scene.SetMesh("/quad", quad);
  EXPECT_EQ(said("mesh.normals.size"), 0u);
  quad.primvars["normals"].value = Array<Vec3f>{{0, 0, 1}};
  stage.scene.SetMesh("/quad", quad);
  EXPECT_EQ(said("mesh.normals.size"), 1u) << "it returned";
}

}  // namespace
}  // namespace alabaster::hd
