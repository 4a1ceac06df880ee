// Instancers that are wrong, and large ones as they are edited. Places and numbers: testenv/conformance.
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "testenv/support/stage.h"

namespace alabaster::hd {
namespace {

size_t count_instances(const std::string& dump) {
  std::istringstream lines(dump);
  size_t count = 0;
  for (std::string line; std::getline(lines, line);) count += line.starts_with("instance ");
  return count;
}

TEST(Instancing, MissingInstancersAndCyclesAreReportedAndNotDrawn) {
  Stage stage;
  host::MeshDescription mesh = Stage::quad();
  mesh.instancer = "/none";
  stage.scene.SetMesh("/lonely", mesh);
  mesh.instancer = "/a";
  stage.scene.SetMesh("/trapped", mesh);
  host::InstancerDescription a, b;
  a.parent = "/b";
  a.indices = {{"/trapped", {0}}, {"/b", {0}}};
  b.parent = "/a";
  b.indices = {{"/a", {0}}};
  stage.scene.SetInstancer("/a", a);
  stage.scene.SetInstancer("/b", b);
  EXPECT_EQ(count_instances(stage.dump()), 0u);
  EXPECT_EQ(stage.count("instancer.cycle"), 1u);
}

TEST(Instancing, AnUnknownInstancerOrMaterialGetsTheNearestPath) {
  Stage stage;
  host::MeshDescription mesh = Stage::quad();
  MaterialNetwork unused;  // its image is not read before a mesh uses it
  unused.nodes["/look/wax/image"] = {"AlabasterTexture", {{"file", "gone.png"}}, {}};
  unused.nodes["/look/wax/surface"] = {"AlabasterDisney", {}, {{"baseColor", {{"/look/wax/image", "rgb"}}}}};
  unused.terminals["surface"] = {"/look/wax/surface", "out"};
  stage.scene.SetMaterial("/look/wax", unused);
  stage.scene.SetInstancer("/many", {});
  mesh.instancer = "/mnay";
  stage.scene.SetMesh("/a", mesh);
  mesh.instancer = {};
  mesh.material = "/look/wx";
  stage.scene.SetMesh("/b", mesh);
  mesh.material = "/something else";
  stage.scene.SetMesh("/c", mesh);
  stage.index->SyncAll();
  std::vector<std::string> texts;
  for (const Diagnostic& d : stage.take_diagnostics()) texts.push_back(d.where + ": " + d.text);
  EXPECT_EQ(texts, (std::vector<std::string>{
                       "/a: instancer /mnay does not exist; the prim is not drawn; did you mean '/many'?",
                       "/b: material /look/wx does not exist; the default is used; did you mean '/look/wax'?",
                       "/c: material /something else does not exist; the default is used"}));
}

// Two outer points and 5000 inner ones, some of which the indices lack.
struct Crowd {
  static constexpr int kPoints = 5000;

  explicit Crowd(Stage* to) : stage(*to) {
    for (int i = 0; i < kPoints; ++i) {
      const auto x = static_cast<float>(i % 100), y = static_cast<float>(i / 100);
      places.emplace_back(x * 0.04f - 2, y * 0.04f - 1, 0.1f * std::sin(x * y));
      indices.push_back(i % 999 == 7 ? kPoints : i);
    }
    outer.primvars["hydra:instanceTranslations"] = Array<Vec3f>{{0, 0, 0}, {0, 0, -1}};
    outer.indices["/inner"] = {0, 1};
    mesh = Stage::quad();
    mesh.transform.setScale(0.01);
    mesh.instancer = "/inner";
    mesh.material = "/matte";
    stage.add_basic_scene();
    stage.scene.Remove("/quad");
    stage.scene.SetMaterial("/matte", surface("baseColor", Vec3f(0.8f, 0.4f, 0.2f)));
    stage.scene.SetInstancer("/outer", outer);
    stage.scene.SetMesh("/mesh", mesh);
    place();
  }
  static MaterialNetwork surface(const char* parameter, const Vec3f& value) {
    MaterialNetwork network;
    network.nodes["surface"] = {"AlabasterDisney", {{parameter, value}}, {}};
    network.terminals["surface"] = {"surface", "surface"};
    return network;
  }
  void place() {
    host::InstancerDescription inner;
    inner.parent = "/outer";
    inner.categories = categories;
    inner.primvars["hydra:instanceTranslations"] = Array<Vec3f>(std::vector<Vec3f>(places));
    inner.indices["/mesh"] = Array<int32_t>(std::vector<int32_t>(indices));
    stage.scene.SetInstancer("/inner", inner);
  }
  std::vector<float> picture(const char* aov, Format format) {
    RenderBuffer* const buffer = stage.add_buffer("/buffer", 32, 32, format);
    const auto pass = stage.delegate->CreateRenderPass();
    stage.index->SyncAll();
    EXPECT_TRUE(Stage::finish(*pass, Stage::state_for(32, 32, aov, buffer)));
    return Stage::pixels<float>(buffer);
  }

  Stage& stage;
  host::MeshDescription mesh;
  host::InstancerDescription outer;
  std::vector<Vec3f> places;
  std::vector<int32_t> indices;
  std::vector<std::vector<Token>> categories;
};

// Names, numbers and transforms of the instances.
std::string instance_lines(const std::string& dump) {
  std::istringstream lines(dump);
  std::string kept;
  bool in_instance = false;
  for (std::string line; std::getline(lines, line);) {
    if (line.substr(0, 1) != " ") in_instance = line.compare(0, 9, "instance ") == 0;
    if (in_instance && (line[0] == 'i' || line.find("transform") != std::string::npos)) kept += line + "\n";
  }
  return kept;
}

// Instances that are in categories of their own stand alone.
TEST(Instancing, AnArrayHasThePlacesNumbersAndFaultsOfItsInstancesAlone) {
  Stage stage;
  Crowd crowd(&stage);
  const std::string array = stage.dump();
  EXPECT_EQ(count_instances(array), 2u * (Crowd::kPoints - 5));
  EXPECT_EQ(stage.count("instancer.index"), 1u);
  host::LightDescription lamp{.type = "sphereLight", .transform = {}, .parameters = {}};
  lamp.parameters["lightLink"] = Token("lit");
  stage.scene.SetLight("/lamp", lamp);
  crowd.categories.resize(Crowd::kPoints);
  crowd.categories[3] = {"lit"};
  crowd.place();
  const std::string alone = stage.dump();
  EXPECT_NE(alone.find("category lit"), std::string::npos);
  EXPECT_EQ(instance_lines(array), instance_lines(alone));
}

TEST(Instancing, AnArrayIsNamedInWhatASceneRequires) {
  Stage stage;
  Crowd crowd(&stage);
  stage.scene.SetMaterial("/matte", Crowd::surface("scatterDistance", Vec3f(0.1f)));
  crowd.mesh.primvars["subsurfaceSet"] = {Interpolation::constant, {}, Token("leaves"), {}};
  stage.scene.SetMesh("/mesh", crowd.mesh);
  stage.index->SyncAll();
  stage.wait_for_scene();
  const std::string text = stage.delegate->InvokeCommand("requirements", {}).value.text_or("");
  EXPECT_NE(text.find("named leaves: 9990 objects"), std::string::npos) << text;
}

TEST(Instancing, AnEditedArrayLooksAsAFreshOne) {
  const auto edit = [](Crowd& crowd) {
    crowd.places[2500] = {0, 0, 1};
    crowd.indices[2501] = 7;
    crowd.outer.transform[3][0] = 0.25;
  };
  Stage stage({{"samples", int64_t(4)}}), fresh({{"samples", int64_t(4)}});
  Crowd crowd(&stage), expected(&fresh);
  const std::vector<float> before = crowd.picture("color", Format::float32vec4);
  edit(crowd);
  crowd.place();
  stage.scene.SetInstancer("/outer", crowd.outer);
  const std::vector<float> after = crowd.picture("color", Format::float32vec4);
  edit(expected);
  expected.place();
  fresh.scene.SetInstancer("/outer", expected.outer);
  EXPECT_NE(after, before);
  EXPECT_EQ(after, expected.picture("color", Format::float32vec4));
  crowd.places[0].x += 0.001f;
  crowd.place();
  stage.wait_for_scene();
  EXPECT_EQ(crowd.picture("instanceId", Format::int32), expected.picture("instanceId", Format::int32));
}

}  // namespace
}  // namespace alabaster::hd
