// Images that cannot be read, where the host renders without them.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "delegate/host/frame_recorder.h"
#include "testenv/support/stage.h"

namespace alabaster::hd {
namespace {

struct LostInput {
  const char *input, *output;
  std::map<Token, Value> constants;
  Vec4f scale, bias;
  const char* expected;  // line of the dump
};

/// Expects that the material takes the constant that the lost image leaves.
void expect_constant(const LostInput& lost) {
  Stage stage;
  MaterialNetwork network;
  network.nodes["/m/surface"] = {"AlabasterDisney", lost.constants, {{lost.input, {{"/m/map", lost.output}}}}};
  network.nodes["/m/map"] = {
      "AlabasterTexture",
      {{"file", AssetPath{"none.png", "none.png", nullptr}}, {"scale", lost.scale}, {"bias", lost.bias}},
      {}};
  network.terminals["surface"] = {"/m/surface", "surface"};
  stage.scene.SetMaterial("/m", network);
  host::MeshDescription mesh = Stage::quad();
  mesh.material = "/m";
  stage.scene.SetMesh("/mesh", mesh);
  const std::string text = stage.dump();
  EXPECT_NE(text.find(std::string("  ") + lost.expected + "\n"), std::string::npos) << lost.expected << "\n" << text;
  EXPECT_EQ(stage.count("texture.missing"), 1u);
}

const Vec4f kOne(1), kZero(0);

// Without its image a direction keeps the rotation that its node adds.
TEST(LostImages, ADirectionTurnsByItsBias) {
  const Vec4f turns(-1.625f, 0, 0, 0);
  const char *const input = "anisotropicRotation", *const output = "direction";
  expect_constant({input, output, {{input, 1.0f}}, kOne, turns, "anisotropicRotation 0.375"});
  expect_constant({input, output, {{input, 0.5f}}, kOne, turns, "anisotropicRotation 0.1875"});
  expect_constant({input, output, {}, kOne, turns, "anisotropicRotation 0.375"});
}

// As where a file names no image: the constant, scaled and shifted, in its range.
// promise: embedding.errors.faults
TEST(LostImages, LostImageCountsAsWhite) {
  const std::map<Token, Value> rough = {{"roughness", 0.25f}}, bright = {{"emission", Vec3f(1, 2, 4)}};
  expect_constant({"roughness", "r", rough, kOne, kZero, "roughness 0.25"});
  expect_constant({"roughness", "b", rough, Vec4f(0.5f), kOne, "roughness 0.375"});
  expect_constant({"roughness", "a", rough, {1, 1, 1, -0.5f}, kOne, "roughness 0.125"});
  expect_constant({"roughness", "r", rough, Vec4f(9), kZero, "roughness 1"});
  expect_constant({"roughness", "r", {}, Vec4f(9), kZero, "roughness 0.5"});
  expect_constant({"emission", "rgb", bright, {0.5f, 1, 1, 1}, {0, 0, 1, 0}, "emission (0.5, 2, 8)"});
}

// The constant that nobody gave is that of no connection at all.
TEST(LostImages, LostImageBesideAnotherConnectionIsReported) {
  Stage stage;
  MaterialNetwork network;
  network.nodes["/m/surface"] = {"AlabasterDisney", {}, {{"baseColor", {{"/m/map", "rgb"}, {"/m/color", "rgb"}}}}};
  network.nodes["/m/map"] = {"AlabasterTexture", {{"file", AssetPath{"none.png", "none.png", nullptr}}}, {}};
  network.nodes["/m/color"] = {"AlabasterPrimvar", {}, {}};
  network.terminals["surface"] = {"/m/surface", "surface"};
  stage.scene.SetMaterial("/m", network);
  host::MeshDescription mesh = Stage::quad();
  mesh.material = "/m";
  stage.scene.SetMesh("/mesh", mesh);
  const std::string text = stage.dump();
  EXPECT_NE(text.find("  baseColor (1, 0, 1)\n"), std::string::npos) << text;
}

// promise: embedding.errors.faults
TEST(LostImages, LostImageOfTheBaseColorIsVisible) {
  expect_constant({"baseColor", "rgb", {{"baseColor", Vec3f(0.5f)}}, kOne, kZero, "baseColor (1, 0, 1)"});
  expect_constant({"baseColor", "rgb", {}, kOne, kZero, "baseColor (1, 0, 1)"});
}

// One report of an image says which materials and lights lack it.
TEST(LostImages, AnImageOfSeveralPrimsIsReportedOnceWithTheirNames) {
  Stage stage;
  for (int i = 0; i < 8; ++i) {
    const std::string name = "/m" + std::to_string(i);
    MaterialNetwork network;
    network.nodes["/m/surface"] = {"AlabasterDisney", {}, {{"baseColor", {{"/m/map", "rgb"}}}}};
    network.nodes["/m/map"] = {"AlabasterTexture", {{"file", AssetPath{"none.png", "none.png", nullptr}}}, {}};
    network.terminals["surface"] = {"/m/surface", "surface"};
    stage.scene.SetMaterial(Path(name), network);
    host::MeshDescription mesh = Stage::quad();
    mesh.material = name;
    stage.scene.SetMesh(Path("/mesh" + name), mesh);
  }
  stage.dump();
  std::vector<std::string> texts;
  for (const Diagnostic& d : stage.take_diagnostics())
    if (d.code == "texture.missing") texts.push_back(d.where + ": " + d.text);
  ASSERT_EQ(texts.size(), 1u);
  EXPECT_EQ(texts[0].find("none.png: "), 0u) << texts[0];
  EXPECT_TRUE(texts[0].ends_with("; named by /m0, /m1, /m2, /m3, /m4 and 3 others")) << texts[0];
}

// promise: security.decoded_once
TEST(LostImages, ADamagedFileIsToldOnceWithAllItsPrims) {
  const std::string path =
      (std::filesystem::temp_directory_path() / ("alabaster_damaged_" + std::to_string(getpid()) + ".tga")).string();
  std::ofstream(path, std::ios::binary) << std::string("\0\0\7\0\0\0\0\0\0\0\0\0\1\0\1\0\x18\0\1\2\3", 21);
  Stage stage;
  for (const std::string name : {"/a", "/b", "/c"}) {
    MaterialNetwork network;
    network.nodes["/m/surface"] = {"AlabasterDisney", {}, {{"baseColor", {{"/m/map", "rgb"}}}}};
    network.nodes["/m/map"] = {"AlabasterTexture", {{"file", AssetPath{path, path, nullptr}}}, {}};
    network.terminals["surface"] = {"/m/surface", "surface"};
    stage.scene.SetMaterial(Path(name), network);
    host::MeshDescription mesh = Stage::quad();
    mesh.material = name;
    stage.scene.SetMesh(Path("/mesh" + name), mesh);
  }
  stage.dump();
  EXPECT_EQ(stage.count("texture.damaged"), 1u);
  for (const char* name : {"/a", "/b", "/c"})
    EXPECT_NE(stage.text_stat("scene.faults").find(name), std::string::npos) << name;
  std::filesystem::remove(path);
}

/// Cuts the open files of this process that have no name and at least so many bytes. Returns how many.
int cut_unnamed_files(off_t least) {
  int cut = 0;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    const int file = std::stoi(entry.path().filename().string());
    struct stat status {};
    if (fstat(file, &status) == 0 && S_ISREG(status.st_mode) && status.st_nlink == 0 && status.st_size >= least)
      cut += ftruncate(file, 0) == 0;
  }
  return cut;
}

/// An image of a million texels.
AssetPath large_image() {
  const std::string bytes =
      "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 16384 +X 64\n" + std::string(size_t(4) << 20, '\x80');
  return {"tall.hdr", "tall.hdr", std::make_shared<const std::vector<uint8_t>>(bytes.begin(), bytes.end())};
}

// A disk may fail while a frame is rendered. Its picture is marked, and none of the later ones is `done`.
TEST(LostImages, TexelsThatCannotBeReadBackAreAFault) {
  Stage stage({{"samples", 4}, {"textureMemory", 1}});
  stage.add_basic_scene();
  MaterialNetwork network;
  network.nodes["/m/surface"] = {"AlabasterDisney", {}, {{"baseColor", {{"/m/map", "rgb"}}}}};
  network.nodes["/m/map"] = {"AlabasterTexture", {{"file", large_image()}}, {}};
  network.terminals["surface"] = {"/m/surface", "surface"};
  stage.scene.SetMaterial("/m", network);
  host::MeshDescription mesh = Stage::quad();
  mesh.material = "/m";
  mesh.primvars["st"] = {Interpolation::vertex, "textureCoordinate", Array<Vec2f>{{0, 0}, {1, 0}, {1, 1}, {0, 1}}, {}};
  stage.scene.SetMesh("/quad", mesh);
  RenderSettingsDescription settings;
  settings.camera = "/camera";
  settings.width = settings.height = 16;
  stage.scene.SetRenderSettings("/settings", settings);
  const auto record = [&] { return host::RecordFrame(stage.index.get(), &stage.scene, "/settings", {}).status; };
  ASSERT_EQ(record(), host::RecordStatus::done);
  ASSERT_EQ(cut_unnamed_files(1 << 20), 1);
  EXPECT_EQ(record(), host::RecordStatus::degraded);
  EXPECT_EQ(stage.count("texture.memory"), 1u);
  EXPECT_NE(stage.text_stat("scene.faults").find("the temporary file of textures"), std::string::npos);
  EXPECT_EQ(record(), host::RecordStatus::render_failed) << "it is known before this one begins";
}

}  // namespace
}  // namespace alabaster::hd
