// Inputs of materials from primvars of a mesh, and of its instances.
#include <gtest/gtest.h>

#include <cmath>

#include "testenv/support/stage.h"

namespace alabaster::hd {
namespace {

constexpr int kSide = 16;

/// An input that a primvar gives, of a material that is otherwise plain.
struct Input {
  const char* name;
  const char* output = "rgb";
  std::map<Token, Value> parameters = {};  // of the surface
};

class PrimvarInputs : public ::testing::Test {
 protected:
  PrimvarInputs() {
    stage.add_basic_scene();
    stage.scene.Remove("/quad");
    stage.scene.SetLight("/dome", {.type = "domeLight", .transform = {}, .parameters = {{"intensity", 0.5f}}});
    pass = stage.delegate->CreateRenderPass();
  }
  ~PrimvarInputs() override { pass.reset(); }

  void connect(const Input& input, const std::map<Token, Value>& reader = {}) {
    MaterialNetwork network;
    std::map<Token, Value> of_reader{{"varname", Token("tint")}};
    for (const auto& [name, value] : reader) of_reader[name] = value;
    network.nodes["/look/tint"] = {"AlabasterPrimvar", of_reader, {}};
    network.nodes["/look/surface"] = {
        "AlabasterDisney", input.parameters, {{input.name, {{"/look/tint", input.output}}}}};
    network.terminals["surface"] = {"/look/surface", "out"};
    stage.scene.SetMaterial("/look", network);
  }
  void shine() { connect({"emission", "rgb", {{"baseColor", Vec3f(0)}, {"specular", 0.0f}}}); }

  std::vector<float> picture(const char* aov = "color") {
    auto* buffer = static_cast<RenderBuffer*>(stage.index->GetBprim("/buffer"));
    if (!buffer) buffer = stage.add_buffer("/buffer", kSide, kSide, Format::float32vec3);
    stage.index->SyncAll();
    EXPECT_TRUE(Stage::finish(*pass, Stage::state_for(kSide, kSide, aov, buffer)));
    return Stage::pixels<float>(buffer);
  }
  /// From -2 to 2, y up.
  static Vec3f at(const std::vector<float>& picture, float x, float y) {
    const int column = int((x + 2) / 4 * kSide), row = int((2 - y) / 4 * kSide);
    const auto* const pixel = &picture[size_t(3 * (row * kSide + column))];
    return {pixel[0], pixel[1], pixel[2]};
  }

  static host::MeshDescription small(host::MeshDescription mesh, double size) {
    mesh.transform.setScale(size);
    mesh.material = "/look";
    return mesh;
  }
  /// Points in a row of which some are left out, each of the others one instance of `mesh`.
  static inline const Array<Vec3f> kPlaces = {{-1.25f, 0, 0}, {9, 9, 9}, {0, 0, 0}, {1.25f, 0, 0}};
  static inline const Array<int32_t> kStanding = {0, 2, 3};
  static host::InstancerDescription row(const Path& prototype) {
    host::InstancerDescription instancer;
    instancer.primvars["hydra:instanceTranslations"] = kPlaces;
    instancer.indices[prototype] = kStanding;
    return instancer;
  }

  Stage stage{{{"samples", int64_t(16)}, {"filter", std::string("box")}}};
  std::unique_ptr<RenderPass> pass;
};

// Two faces beside each other, of six points.
// promise: artists.primvar_inputs
TEST_F(PrimvarInputs, AMeshHasOneToFourNumbersAtEveryRate) {
  host::MeshDescription mesh;
  mesh.topology.faceVertexCounts = {4, 4};
  mesh.topology.faceVertexIndices = {0, 1, 4, 3, 1, 2, 5, 4};
  mesh.primvars["points"].value = Array<Vec3f>{{-2, -1, 0}, {0, -1, 0}, {2, -1, 0}, {-2, 1, 0}, {0, 1, 0}, {2, 1, 0}};
  mesh.material = "/look";
  shine();
  stage.scene.SetLight("/dome", {.type = "domeLight", .transform = {}, .parameters = {{"intensity", 0.0f}}});
  struct Rate {
    Interpolation rate;
    std::vector<float> values;  // of x
    float left, right;          // at x of -1 and 1
  };
  const Rate rates[] = {{Interpolation::constant, {0.5f}, 0.5f, 0.5f},
                        {Interpolation::uniform, {0.25f, 0.75f}, 0.25f, 0.75f},
                        {Interpolation::varying, {0, 1, 1, 0, 1, 1}, 0.5f, 1},
                        {Interpolation::vertex, {0, 1, 1, 0, 1, 1}, 0.5f, 1},
                        {Interpolation::faceVarying, {1, 1, 1, 1, 0, 1, 1, 0}, 1, 0.5f}};
  for (const auto& [rate, x, left, right] : rates) {
    std::vector<Vec2f> two;
    std::vector<Vec3f> three;
    std::vector<Vec4f> four;
    for (const float v : x) two.emplace_back(v, 0.5f), three.emplace_back(v, 0.5f, 2), four.emplace_back(v, 0.5f, 2, 9);
    const std::pair<Value, Vec3f> values[] = {{Array<float>(std::vector<float>(x)), Vec3f(1, 1, 1)},
                                              {Array<Vec2f>(two), Vec3f(1, 0.5f, 0)},
                                              {Array<Vec3f>(three), Vec3f(1, 0.5f, 2)},
                                              {Array<Vec4f>(four), Vec3f(1, 0.5f, 2)}};
    for (const auto& [value, shown] : values) {
      mesh.primvars["tint"] = {rate, {}, value, {}};
      stage.scene.SetMesh("/mesh", mesh);
      const auto seen = picture();
      for (const auto& [place, wanted] : {std::pair(-1.0f, left), std::pair(1.0f, right)}) {
        const Vec3f pixel = at(seen, place, 0);
        const bool is_grey = value.type() == ALABASTER_FLOAT;
        const Vec3f expected = is_grey ? Vec3f(wanted) : Vec3f(wanted, shown.y, shown.z);
        EXPECT_LT(length(pixel - expected), 0.15f) << int(rate) << " " << value.to_string() << " " << place;
      }
    }
  }
}

TEST_F(PrimvarInputs, TheReaderHasAFallbackAndPlacesItsNumbers) {
  host::MeshDescription mesh = small(Stage::quad(), 1);
  const Input emission{"emission", "rgb", {{"baseColor", Vec3f(0)}, {"specular", 0.0f}}};
  connect(emission, {{"fallback", Vec3f(0.25f, 0.5f, 1)}, {"scale", Vec4f(2)}, {"bias", Vec4f(1)}});
  stage.scene.SetMesh("/mesh", mesh);
  EXPECT_EQ(at(picture(), 0, 0), Vec3f(0.25f, 0.5f, 1));
  mesh.primvars["tint"] = {Interpolation::constant, {}, Array<Vec3f>{{0, 0.5f, 1}}, {}};
  stage.scene.SetMesh("/mesh", mesh);
  EXPECT_EQ(at(picture(), 0, 0), Vec3f(1, 2, 3));
  connect(emission);
  mesh.primvars.erase("tint");
  stage.scene.SetMesh("/mesh", mesh);
  EXPECT_EQ(at(picture(), 0, 0), Vec3f(0, 0, 0)) << "no fallback: 0";
}

// Whatever the input, the picture is that of meshes whose materials have the values as constants, to the last bit: but
// for emission, whose mean over a triangle is rounded.
// promise: artists.values_by_instance
TEST_F(PrimvarInputs, InstancesLookAsMeshesWithMaterialsOfTheirOwn) {
  const Vec3f tints[] = {{0.8f, 0.2f, 0.1f}, {9, 9, 9}, {0.2f, 0.7f, 0.3f}, {0.1f, 0.3f, 0.9f}};
  const Input inputs[] = {{"baseColor"},
                          {"roughness", "g", {{"metallic", 1.0f}}},
                          {"emission"},
                          {"opacity", "r", {{"opacityThreshold", 0.5f}}},
                          {"subsurfaceColor", "rgb", {{"scatterDistance", Vec3f(0.5f)}}},
                          {"scatterDistance", "rgb", {{"baseColor", Vec3f(0.9f, 0.5f, 0.3f)}}}};
  for (const Input& input : inputs) {
    connect(input);
    const host::MeshDescription cube = small(Stage::cube(1), 0.5);
    for (size_t i = 0; i < kStanding.size(); ++i) {
      host::MeshDescription one = cube;
      const auto point = static_cast<size_t>(kStanding[i]);
      for (int axis = 0; axis < 3; ++axis) one.transform[3][axis] = double(kPlaces[point][axis]);
      const Path path("/mesh_" + std::to_string(i)), look("/look_" + std::to_string(i));
      const Vec3f& tint = tints[point];
      std::map<Token, Value> constants = input.parameters;
      constants[input.name] =
          input.output == std::string("rgb") ? Value(tint) : Value(input.output[0] == 'r' ? tint.x : tint.y);
      stage.set_surface(look, constants);
      one.material = look;
      stage.scene.SetMesh(path, one);
    }
    const auto alone = picture();
    for (const char* path : {"/mesh_0", "/mesh_1", "/mesh_2"}) stage.scene.Remove(path);

    host::MeshDescription many = cube;
    many.instancer = "/row";
    many.primvars["tint"] = {Interpolation::constant, {}, Array<Vec3f>{{0.5f, 0.5f, 0.5f}}, {}};
    host::InstancerDescription row = PrimvarInputs::row("/many");
    row.primvars["tint"] = Array<Vec3f>(std::vector<Vec3f>(std::begin(tints), std::end(tints)));
    stage.scene.SetMesh("/many", many);
    stage.scene.SetInstancer("/row", row);
    const auto seen = picture();
    float apart = 0;
    for (size_t i = 0; i < seen.size(); ++i) apart = std::max(apart, std::abs(seen[i] - alone[i]));
    EXPECT_LE(apart, input.name == std::string("emission") ? 1e-3f : 0.0f) << input.name;
    row.primvars.erase("tint");
    stage.scene.SetInstancer("/row", row);
    EXPECT_NE(picture(), alone) << input.name << ": the mesh's own";
    stage.scene.Remove("/many"), stage.scene.Remove("/row");
  }
}

// AOVs have the very numbers. The outer instancer moves up.
TEST_F(PrimvarInputs, TheInnermostInstanceWithAValueHasIt) {
  host::MeshDescription mesh = small(Stage::quad(), 0.25);
  mesh.instancer = "/inner";
  mesh.primvars["tint"] = {Interpolation::constant, {}, Array<float>{1}, {}};
  stage.scene.SetMesh("/mesh", mesh);
  host::InstancerDescription inner = row("/mesh"), outer;
  inner.parent = "/outer";
  outer.primvars["hydra:instanceTranslations"] = Array<Vec3f>{{0, -1, 0}, {0, 1, 0}};
  outer.indices["/inner"] = {1, 0};
  const auto seen = [&](float x, float y) {
    stage.scene.SetInstancer("/inner", inner), stage.scene.SetInstancer("/outer", outer);
    return at(picture("primvars:tint"), x, y);
  };
  EXPECT_EQ(seen(0, 1), Vec3f(1, 0, 0)) << "the mesh's own";
  outer.primvars["tint"] = Array<Vec2f>{{2, 3}, {4, 5}};
  EXPECT_EQ(seen(0, 1), Vec3f(4, 5, 0)) << "the outer one's";
  EXPECT_EQ(seen(-1.25f, -1), Vec3f(2, 3, 0));
  inner.primvars["tint"] = Array<Vec3f>{{6, 6, 6}, {7, 7, 7}, {8, 9, 10}, {11, 12, 13}};
  EXPECT_EQ(seen(0, 1), Vec3f(8, 9, 10)) << "the inner one's";
  EXPECT_EQ(seen(1.25f, -1), Vec3f(11, 12, 13));
  // An edit of one value shows.
  stage.scene.SetInstanceValues("/inner", "tint", 2, Array<Vec3f>{{0, 1, 2}});
  EXPECT_EQ(at(picture("primvars:tint"), 0, -1), Vec3f(0, 1, 2));
}

// promise: artists.values_unread
TEST_F(PrimvarInputs, AValueThatNothingReadsIsNoChange) {
  connect({"baseColor"});
  host::MeshDescription mesh = small(Stage::quad(), 0.25);
  mesh.instancer = "/row";
  stage.scene.SetMesh("/mesh", mesh);
  host::InstancerDescription row = PrimvarInputs::row("/mesh");
  row.primvars["tint"] = Array<Vec3f>{{1, 0, 0}, {0, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  row.primvars["age"] = Array<float>{1, 2, 3, 4};
  stage.scene.SetInstancer("/row", row);
  const auto seen = picture();
  const double scene = stage.stat("sceneNumber");
  row.primvars["age"] = Array<float>{5, 6, 7, 8};
  row.primvars["displayColor"] = kPlaces;
  stage.scene.SetInstancer("/row", row);
  EXPECT_EQ(picture(), seen);
  EXPECT_EQ(stage.stat("sceneNumber"), scene) << "no material reads them";
  row.primvars["tint"] = Array<Vec3f>{{1, 0, 0}, {0, 0, 0}, {1, 1, 0}, {0, 0, 1}};
  stage.scene.SetInstancer("/row", row);
  EXPECT_NE(picture(), seen);
  EXPECT_GT(stage.stat("sceneNumber"), scene);
  EXPECT_EQ(at(picture("primvars:age"), 0, 0), Vec3f(7, 0, 0)) << "an AOV reads it";
  row.primvars["age"] = Array<float>{5, 6, 9, 8};
  stage.scene.SetInstancer("/row", row);
  EXPECT_EQ(at(picture("primvars:age"), 0, 0), Vec3f(9, 0, 0));
}

// From 8192 instances on they are an array, unless lights take them apart.
TEST_F(PrimvarInputs, AnArrayHasValuesToo) {
  constexpr int kCount = 10000, kColumns = 100;
  connect({"baseColor"});
  std::vector<Vec3f> places, tints;
  std::vector<int32_t> points;
  for (int i = 0; i < kCount; ++i) {
    const auto x = float(i % kColumns) / kColumns, y = float(i) / kCount;
    places.emplace_back(4 * x - 2, 4 * y - 2, 0);
    tints.emplace_back(x, y, 0.5f);
    points.push_back(kCount - 1 - i);
  }
  host::MeshDescription mesh = small(Stage::quad(), 0.02);
  mesh.instancer = "/field";
  stage.scene.SetMesh("/mesh", mesh);
  host::InstancerDescription field;
  field.primvars["hydra:instanceTranslations"] = Array<Vec3f>(places);
  field.primvars["tint"] = Array<Vec3f>(tints);
  field.indices["/mesh"] = Array<int32_t>(points);
  stage.scene.SetInstancer("/field", field);
  const auto array = picture("primvars:tint");
  EXPECT_NEAR(at(array, 1, -1).x, 0.75f, 0.05f);
  EXPECT_NEAR(at(array, 1, -1).y, 0.25f, 0.05f);
  host::LightDescription lamp{.type = "sphereLight", .transform = {}, .parameters = {{"intensity", 0.0f}}};
  lamp.parameters["lightLink"] = Token("lit");
  stage.scene.SetLight("/lamp", lamp);
  field.categories = {{"lit"}};
  stage.scene.SetInstancer("/field", field);
  EXPECT_EQ(picture("primvars:tint"), array);
}

TEST_F(PrimvarInputs, WhatDoesNotFitIsToldByItsName) {
  host::MeshDescription mesh = small(Stage::quad(), 0.25);
  mesh.instancer = "/row";
  mesh.primvars["tint"] = {Interpolation::vertex, {}, Array<float>{1, 2, 3}, {}};
  shine();
  stage.scene.SetMesh("/mesh", mesh);
  host::InstancerDescription row = PrimvarInputs::row("/mesh");
  row.primvars["tint"] = Array<Vec3f>{{1, 1, 1}, {2, 2, 2}};
  stage.scene.SetInstancer("/row", row);
  stage.index->SyncAll();
  std::vector<std::string> texts;
  for (const Diagnostic& d : stage.take_diagnostics()) texts.push_back(d.where + ": " + d.text);
  std::sort(texts.begin(), texts.end());
  EXPECT_EQ(texts,
            (std::vector<std::string>{"/mesh: primvar tint has 3 values, 4 are needed (one per point); ignored",
                                      "/row: primvar tint has 2 values, 4 are needed (one per instance); ignored"}));

  // Points that come later are asked for theirs, as in a fresh scene.
  row.primvars["tint"] = kPlaces;
  stage.scene.SetInstancer("/row", row);
  stage.index->SyncAll();
  EXPECT_TRUE(stage.take_diagnostics().empty());
  std::vector<Vec3f> more(kPlaces.begin(), kPlaces.end());
  more.push_back({0, 1, 0});
  row.primvars["hydra:instanceTranslations"] = Array<Vec3f>(more);
  stage.scene.SetInstancer("/row", row);
  stage.index->SyncAll();
  const std::vector<Diagnostic> later = stage.take_diagnostics();
  ASSERT_EQ(later.size(), 1u);
  EXPECT_EQ(later[0].text, "primvar tint has 4 values, 5 are needed (one per instance); ignored");
}

}  // namespace
}  // namespace alabaster::hd
