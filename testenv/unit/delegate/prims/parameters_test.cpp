// Parameters, settings and nodes that a host gives wrongly, and types that there are not.
#include <gtest/gtest.h>

#include <fstream>
#include <limits>
#include <set>

#include "testenv/support/build_paths.h"
#include "testenv/support/stage.h"

namespace alabaster::hd {
namespace {

MaterialNetwork disney(const std::map<Token, Value>& parameters) {
  MaterialNetwork network;
  network.nodes["/m/surface"] = {"AlabasterDisney", parameters, {}};
  network.terminals["surface"] = {"/m/surface", "surface"};
  return network;
}

// A host's curve may overshoot.
TEST(Parameters, AMeshOptionOutOfRangeIsReported) {
  Stage stage;
  host::MeshDescription mesh = Stage::quad();
  mesh.primvars["holdout"] = {Interpolation::constant, {}, std::numeric_limits<float>::infinity(), {}};
  stage.scene.SetMesh("/mesh", mesh);
  EXPECT_NE(stage.dump().find("\n  holdout true\n"), std::string::npos);
  EXPECT_EQ(stage.count("parameter.range"), 1u);
}

TEST(Parameters, ColorTemperatureIsAColorOfTheRenderingSpace) {
  Stage stage;
  stage.scene.SetLight("/lamp", {.type = "sphereLight",
                                 .transform = {},
                                 .parameters = {{"enableColorTemperature", true}, {"colorTemperature", 2700.0f}}});
  const std::string text = stage.dump();
  const size_t at = text.find("  color of temperature (");
  ASSERT_NE(at, std::string::npos) << text;
  Vec3f rgb;
  ASSERT_EQ(std::sscanf(text.c_str() + at, "  color of temperature (%f, %f, %f)", &rgb.x, &rgb.y, &rgb.z), 3);
  EXPECT_GT(rgb.x, rgb.y);
  EXPECT_GT(rgb.y, rgb.z);
  EXPECT_GT(rgb.z, 0);
}

TEST(Parameters, AnIesProfileArrivesAndABrokenOneIsAFault) {
  const std::string path = ::testing::TempDir() + "lamp.ies";
  std::ofstream(path) << "TILT=NONE\n1 -1 1 2 1 1 2 0 0 0\n1 1 1\n0 180\n0\n6 6\n";
  Stage stage;
  host::LightDescription light{.type = "sphereLight", .transform = {}, .parameters = {}};
  light.parameters["shaping:ies:file"] = AssetPath{path, path, nullptr};
  stage.scene.SetLight("/lamp", light);
  EXPECT_NE(stage.dump().find("  profile mean 6\n"), std::string::npos);
  EXPECT_EQ(stage.count("ies.invalid"), 0u);
  std::ofstream(path) << "TILT=NONE\n1 -1 1 2 1 3 2 0 0 0\n";
  light.parameters["intensity"] = 2.0f;
  stage.scene.SetLight("/lamp", light);
  EXPECT_EQ(stage.dump().find("profile"), std::string::npos);
  EXPECT_EQ(stage.count("ies.invalid"), 1u);
}

TEST(Parameters, ASettingOfAPrimThatIsOutOfRangeIsReported) {
  Stage stage;
  RenderSettingsDescription settings;
  settings.settings["maxDepth"] = int64_t(-3);
  settings.settings["seed"] = std::string("seven");
  stage.scene.SetRenderSettings("/settings", settings);
  stage.take_diagnostics();
  stage.index->SyncAll();
  std::set<std::string> codes;
  for (const Diagnostic& one : stage.take_diagnostics()) {
    EXPECT_EQ(one.where, "/settings") << one.text;
    codes.insert(one.code);
  }
  EXPECT_EQ(codes, (std::set<std::string>{"parameter.range", "parameter.type"}));
}

TEST(Parameters, AScatterDistanceBesideAMeanFreePathIsTold) {
  Stage stage;
  stage.scene.SetMaterial("/m", disney({{"scatterDistance", Vec3f(1)}, {"meanFreePath", Vec3f(1)}}));
  stage.scene.SetMaterial("/part", disney({{"scatterDistance", Vec3f(1)}, {"meanFreePath", Vec3f(1, 0, 1)}}));
  stage.index->SyncAll();
  EXPECT_EQ(stage.count("material.scatter"), 1u) << "the other one has a channel of each";
}

TEST(Parameters, WrongOnesAreReportedWithARemedy) {
  Stage stage;
  stage.scene.SetMaterial("/m", disney({{"rouhgness", 0.1f}, {"metallic", 7.0f}, {"sheen", "much"}}));
  stage.index->SyncAll();
  EXPECT_EQ(stage.count("parameter.range"), 1u);
  EXPECT_EQ(stage.count("parameter.type"), 1u);
  for (const Diagnostic& d : stage.take_diagnostics()) {
    EXPECT_EQ(d.where, "/m");
    EXPECT_EQ(d.text.find("named by"), d.text.npos) << d.text;
    if (d.code == "material.parameter") {
      EXPECT_NE(d.text.find("'roughness'"), std::string::npos) << d.text;
    }
  }
  stage.delegate->SetRenderSetting("samples", 0);
  EXPECT_EQ(stage.count("parameter.range"), 1u);
  stage.delegate->SetRenderSetting("filter", "mitchell");
  EXPECT_EQ(stage.count("parameter.type"), 1u);
}

TEST(MaterialSync, UnknownNodesFallBackWithOneReport) {
  Stage stage;
  MaterialNetwork unknown = disney({});
  unknown.nodes["/m/surface"].nodeTypeId = "StandardSurface";
  stage.scene.SetMaterial("/unknown", unknown);
  MaterialNetwork dangling = disney({});
  dangling.terminals["surface"].upstreamNode = "/m/nowhere";
  stage.scene.SetMaterial("/dangling", dangling);
  MaterialNetwork connected = disney({{"baseColor", Vec3f(0.5f, 0.5f, 0.5f)}});
  connected.nodes["/m/noise"] = {"Noise", {}, {}};
  connected.nodes["/m/surface"].inputConnections["baseColor"] = {{"/m/noise", "rgb"}};
  stage.scene.SetMaterial("/connected", connected);
  host::MeshDescription mesh = Stage::quad();
  mesh.material = "/unknown";
  stage.scene.SetMesh("/mesh", mesh);
  EXPECT_NE(stage.dump().find("material /unknown\n  baseColor (0.8, 0.8, 0.8)"), std::string::npos);
  EXPECT_EQ(stage.count("material.node"), 2u);
  EXPECT_EQ(stage.count("material.surface"), 1u);
}

/// One grey pixel of 0.5 as a Radiance file.
AssetPath grey_image(const std::string& name) {
  const std::string text = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n\x80\x80\x80\x80";
  return {name, name, std::make_shared<const std::vector<uint8_t>>(text.begin(), text.end())};
}

TEST(MaterialSync, ScatterDistanceTakesATexture) {
  const auto dump = [](const std::map<Token, Value>& parameters, const AssetPath& file, size_t reports) {
    Stage stage;
    MaterialNetwork network = disney(parameters);
    network.nodes["/m/map"] = {"AlabasterTexture", {{"file", file}}, {}};
    network.nodes["/m/surface"].inputConnections["scatterDistance"] = {{"/m/map", "rgb"}};
    stage.scene.SetMaterial("/m", network);
    host::MeshDescription mesh = Stage::quad();
    mesh.material = "/m";
    stage.scene.SetMesh("/mesh", mesh);
    std::string text = stage.dump();
    text += stage.delegate->InvokeCommand("requirements", {}).value.text_or("");
    size_t said = 0;
    for (const Diagnostic& d : stage.take_diagnostics()) said += d.code.starts_with("texture.");
    EXPECT_EQ(said, reports);
    return text;
  };
  const auto has = [](const std::string& text, const std::string& part) {
    EXPECT_NE(text.find(part), std::string::npos) << part << "\n" << text;
  };
  const AssetPath grey = grey_image("grey.hdr");
  const std::string scaled = dump({{"scatterDistance", Vec3f(2, 3, 4)}}, grey, 0);
  has(scaled, "  scatterDistance (2, 3, 4)\n");
  has(scaled, "  scatterDistance texture 1x1 st rgb\n");
  has(scaled, "subsurface: yes");
  has(scaled, "textures: yes");
  const std::string alone = dump({}, grey, 0);
  has(alone, "  scatterDistance (1, 1, 1)\n");
  has(alone, "  scatterDistance texture 1x1 st rgb\n");
  const std::string nothing = dump({{"scatterDistance", Vec3f(0, 0, 0)}}, grey, 0);
  EXPECT_EQ(nothing.find("scatterDistance texture"), std::string::npos) << nothing;
  has(nothing, "subsurface: no");
  has(nothing, "textures: no");
  const std::string absent = dump({}, {"none.exr", "none.exr", nullptr}, 1);
  has(absent, "  scatterDistance (0, 0, 0)\n");
  has(absent, "subsurface: no");
}

// Numbers are read from an output each; an angle has an output of its own.
TEST(MaterialSync, ADirectionIsAnOutputForAnglesAlone) {
  for (const auto& [input, reports] :
       {std::pair{"anisotropicRotation", 0u}, {"opacity", 1u}, {"baseColor", 1u}, {"bump", 1u}}) {
    Stage stage;
    MaterialNetwork network = disney({});
    network.nodes["/m/map"] = {"AlabasterTexture", {{"file", grey_image("grey.hdr")}}, {}};
    network.nodes["/m/surface"].inputConnections[input] = {{"/m/map", "direction"}};
    stage.scene.SetMaterial("/m", network);
    host::MeshDescription mesh = Stage::quad();
    mesh.material = "/m";
    stage.scene.SetMesh("/mesh", mesh);
    const std::string text = stage.dump();
    EXPECT_EQ(stage.count("material.output"), reports) << input;
    EXPECT_EQ(text.find("direction") != std::string::npos, reports == 0) << text;
  }
}

/// The scene's memory with a grey image of 2 MiB, as halves, connected to these inputs.
double memory_with_image(Stage& stage, const std::map<Token, Token>& outputs) {
  std::string text = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 16384 +X 64\n";
  text.append(size_t(4) << 20, '\x80');
  const AssetPath file{"tall.hdr", "tall.hdr", std::make_shared<const std::vector<uint8_t>>(text.begin(), text.end())};
  MaterialNetwork network = disney({});
  network.nodes["/m/map"] = {"AlabasterTexture", {{"file", file}}, {}};
  for (const auto& [input, output] : outputs)
    network.nodes["/m/surface"].inputConnections[input] = {{"/m/map", output}};
  stage.scene.SetMaterial("/m", network);
  host::MeshDescription mesh = Stage::quad();
  mesh.material = "/m";
  stage.scene.SetMesh("/mesh", mesh);
  stage.index->SyncAll();
  EXPECT_EQ(stage.count("texture.memory"), 0u);
  return stage.stat("totalMemory");
}

TEST(MaterialSync, TextureMemoryIsWhatTheHostSetsElseWhatASettingsPrimDoes) {
  const auto memory = [&](const Dictionary& host, const Dictionary& described) {
    Stage stage(host);
    RenderSettingsDescription settings;
    settings.settings = described;
    stage.scene.SetRenderSettings("/settings", settings);
    return memory_with_image(stage, {{"baseColor", "rgb"}});
  };
  const double held = memory({}, {});
  EXPECT_GT(held, 0x1p21);
  EXPECT_LT(memory({{"textureMemory", 1}}, {}), held - 0x1.fp20);
  EXPECT_LT(memory({}, {{"textureMemory", 1}}), held - 0x1.fp20);
  EXPECT_EQ(memory({{"textureMemory", 64}}, {{"textureMemory", 1}}), held);
}

TEST(Delegate, VersionsNameWhatItStandsOn) {
  const std::string versions = AlabasterVersions();
  for (const char* name :
       {"Embree ", "OpenSubdiv 3.", "OpenImageIO 2.", "OpenColorIO 2.", "TBB 20", "Imath 3.", "tinygltf 2."})
    EXPECT_NE(versions.find(name), std::string::npos) << name << " in\n" << versions;
}

TEST(Delegate, UnknownCommandsAndArgumentsAreErrors) {
  Stage stage;
  const auto expect = [&](const char* command, const Dictionary& arguments, CommandStatus status, const char* fault) {
    const CommandResult result = stage.delegate->InvokeCommand(command, arguments);
    EXPECT_EQ(result.status, status) << command;
    EXPECT_NE(result.fault.find(fault), std::string::npos) << result.fault;
    EXPECT_TRUE(result.value.empty());
  };
  expect("dance", {}, CommandStatus::unknown, "there is no command 'dance'");
  expect("dumpscene", {}, CommandStatus::unknown, "did you mean 'dumpScene'?");
  expect("resumeCheckpoint", {{"flie", "a"}}, CommandStatus::invalid, "did you mean 'file'?");
  expect("writeCheckpoint", {}, CommandStatus::invalid, "needs the argument 'file'");
  expect("reloadResource", {{"file", 3}}, CommandStatus::invalid, "'file' must be a text");
  expect("showCheckpoints", {{"files", "a"}}, CommandStatus::invalid, "'files' must be an array of texts");
  expect("waitForScene", {{"seconds", "long"}}, CommandStatus::invalid, "'seconds' must be a number");
  expect("writeCheckpoint", {{"file", "a"}}, CommandStatus::failed, "nothing has been rendered");
  EXPECT_TRUE(stage.delegate->InvokeCommand("flush", {}).ok());
  stage.add_basic_scene();
  stage.index->SyncAll();
  const std::string requirements = stage.delegate->InvokeCommand("requirements", {}).value.text_or("");
  EXPECT_NE(requirements.find("subsurface: no"), std::string::npos) << requirements;
  EXPECT_NE(requirements.find("instances: 1 of 1 meshes"), std::string::npos) << requirements;
}

TEST(MaterialSync, AlphaComesFromTheImageThatIsReadForColors) {
  Stage one, both;
  EXPECT_LT(memory_with_image(both, {{"baseColor", "rgb"}, {"opacity", "a"}}),
            memory_with_image(one, {{"baseColor", "rgb"}}) + 0x1p20);
}

}  // namespace
}  // namespace alabaster::hd
