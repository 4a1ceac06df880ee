// Arrays that are lent come back once, whatever fails.
#include <deque>
#include <functional>

#include "testenv/support/failing_memory.h"
#include "testenv/unit/delegate/c_api/door_fixture.h"

namespace alabaster::c_api_testing {
namespace {

constexpr float kNumbers[64] = {};
constexpr int32_t kInts[4] = {0, 1, 2, 3};
constexpr double kMatrix[16] = {};

/// Everything that can lend something lends it here, and counts what comes back.
class DoorReleases : public Door {
 protected:
  AlabasterValue lent(AlabasterValue value) {
    ++given_;
    value.release = &count_release, value.owner = &released_;
    return value;
  }
  AlabasterValue floats() { return lent(array(ALABASTER_FLOAT, kNumbers, 4)); }
  AlabasterValue ints() { return lent(array(ALABASTER_INT, kInts, 4)); }
  AlabasterValue points() { return lent(array(ALABASTER_FLOAT3, kNumbers, 4)); }
  AlabasterValue moving(AlabasterValue first, AlabasterValue second) {
    samples_.push_back({AlabasterSample{0, first}, {1, second}});
    return lent({ALABASTER_SAMPLES, ALABASTER_SCALAR, samples_.back().data(), 2, nullptr, nullptr});
  }
  AlabasterValue moving_matrix() { return moving(lent(matrix(kMatrix)), lent(matrix(kMatrix))); }
  Fields mesh() {
    return {{"faceVertexCounts", ints()},
            {"faceVertexIndices", ints()},
            {"holeIndices", ints()},
            {"invisibleFaces", ints()},
            {"primvars:points", points()},
            {"primvars:points:samples", moving(points(), points())},
            {"primvars:normals", points()},
            {"primvars:normals:indices", ints()},
            {"primvars:normals:samples", moving(points(), points())},
            {"subsets:a:faces", ints()},
            {"creaseIndices", ints()},
            {"creaseLengths", ints()},
            {"creaseWeights", floats()},
            {"cornerIndices", ints()},
            {"cornerWeights", floats()},
            {"transform", lent(matrix(kMatrix))},
            {"transform:samples", moving_matrix()},
            {"categories", lent(array(ALABASTER_TOKEN, kWords, 1))}};
  }
  Fields instancer() {
    return {{"primvars:hydra:instanceTranslations", points()},
            {"primvars:hydra:instanceTranslations:samples", moving(points(), points())},
            {"prototypes:/quad", ints()},
            {"categories:a", ints()},
            {"transform:samples", moving_matrix()}};
  }
  Fields material() {
    return {{"surface.type", lent(word("AlabasterDisney"))},
            {"surface.baseColor", lent(scalar(ALABASTER_FLOAT3, kNumbers))},
            {"surface.normal", lent(array(ALABASTER_PATH, kOutputs, 1))}};
  }
  Fields lens() {
    return {{"clipPlanes", lent(array(ALABASTER_FLOAT4, kNumbers, 2))}, {"transform:samples", moving_matrix()}};
  }
  Fields settings() { return {{"crop", ints()}, {"includedPurposes", lent(array(ALABASTER_TOKEN, kWords, 1))}}; }
  struct Prim {
    const char* kind;
    Fields fields;
  };
  std::vector<Prim> prims() {
    return {{"mesh", mesh()},
            {"instancer", instancer()},
            {"material", material()},
            {"camera", lens()},
            {"domeLight", {{"intensity", lent(number(kNumbers[0]))}}},
            {"renderSettings", settings()}};
  }
  AlabasterFrame frame() {
    AlabasterFrame made = {};
    made.size = sizeof made;
    free_camera_ = lens();
    made.free_camera = free_camera_.data(), made.free_camera_count = free_camera_.size();
    made.roots = ints();  // of the wrong type
    return made;
  }
  const AlabasterParameter* parameters() {
    parameters_ = {{"a", floats()}, {"b", ints()}};
    return parameters_.data();
  }

  /// After `call`, which fails.
  void expect_all_back(const char* what, AlabasterStatus status) {
    EXPECT_NE(status, ALABASTER_OK) << what;
    EXPECT_GT(given_, 0) << what;
    EXPECT_EQ(released_, given_) << what;
    released_ = given_ = 0;
    samples_.clear();
  }
  /// For each kind of prim in turn, of which `call` must fail.
  void expect_all_back(const std::function<AlabasterStatus(const Prim&)>& call) {
    for (size_t kind = 0; kind < 6; ++kind) {
      std::vector<Prim> all = prims();
      const Prim& prim = all[kind];
      given_ = 0;
      for (const AlabasterParameter& field : prim.fields) given_ += lent_with(field.value);
      expect_all_back(prim.kind, call(prim));
    }
  }
  static int lent_with(const AlabasterValue& value) {
    int count = value.release ? 1 : 0;
    if (value.type == ALABASTER_SAMPLES)
      for (size_t i = 0; i < value.count; ++i)
        count += lent_with(static_cast<const AlabasterSample*>(value.data)[i].value);
    return count;
  }

  static constexpr const char* kWords[] = {"a"};
  static constexpr const char* kOutputs[] = {"surface.out"};
  int given_ = 0, released_ = 0;
  std::deque<std::array<AlabasterSample, 2>> samples_;
  Fields parameters_, free_camera_;
};

TEST_F(DoorReleases, CallsWithoutASceneAPathOrAKindRelease) {
  for (const char* path : {static_cast<const char*>(nullptr), "", "/a"}) {
    AlabasterScene* const scene = path && *path ? nullptr : scene_;
    expect_all_back([&](const Prim& prim) { return set(scene, path, prim.kind, prim.fields); });
    expect_all_back([&](const Prim& prim) { return edit(scene, path, prim.fields); });
    const auto values = points();
    expect_all_back("scene_set_instances",
                    api().scene_set_instances(scene, path, "hydra:instanceTranslations", 0, &values));
  }
  for (const char* kind : {static_cast<const char*>(nullptr), "", "mash"})
    expect_all_back([&](const Prim& prim) { return set(scene_, "/a", kind, prim.fields); });
  expect_all_back([&](const Prim& prim) { return edit(scene_, "/missing", prim.fields); });
}

TEST_F(DoorReleases, StructsWithoutASizeRelease) {
  auto unsized = frame();
  unsized.size = 0;
  expect_all_back("pass_start", api().pass_start(pass_, &unsized));
  const AlabasterDelegateOptions options = {0, nullptr, nullptr, parameters(), 2};
  expect_all_back("delegate_create", api().delegate_create(&options, nullptr, nullptr));
}

TEST_F(DoorReleases, FaultyFieldsRelease) {
  const float nothing = 0;
  const AlabasterParameter faults[] = {{"unknown", number(nothing)},
                                       {nullptr, number(nothing)},
                                       {"transform", number(nothing)},
                                       {"primvars:points", array(77, &nothing, 1)},
                                       {"primvars:points", array(ALABASTER_FLOAT3, &nothing, ~size_t(0) / 8)},
                                       {"primvars:points", array(ALABASTER_FLOAT3, nullptr, 1)}};
  for (const AlabasterParameter& fault : faults)
    for (const bool is_first : {true, false}) {
      SCOPED_TRACE(fault.name ? fault.name : "no name");
      const auto with_fault = [&](const Prim& prim) {
        Fields fields = prim.fields;
        fields.insert(is_first ? fields.begin() : fields.end(), fault);
        return fields;
      };
      expect_all_back([&](const Prim& prim) { return set(scene_, "/a", prim.kind, with_fault(prim)); });
      expect_all_back([&](const Prim& prim) { return edit(scene_, "/quad", with_fault(prim)); });
    }
}

TEST_F(DoorReleases, FaultySamplesRelease) {
  const auto set_points = [&](AlabasterValue value) {
    return set(scene_, "/a", "mesh", {{"primvars:points", points()}, {"primvars:points:samples", value}});
  };
  expect_all_back("nothing within",
                  set_points(lent({ALABASTER_SAMPLES, ALABASTER_SCALAR, nullptr, 2, nullptr, nullptr})));
  expect_all_back("one of no type", set_points(moving(points(), lent(array(77, kNumbers, 1)))));
  expect_all_back("samples of samples", set_points(moving(points(), moving(points(), points()))));
  EXPECT_TRUE(says("samples of samples")) << api().last_error();
  expect_all_back("in the place of points",
                  set(scene_, "/a", "mesh", {{"primvars:points", moving(points(), points())}}));
  expect_all_back("of what has none", set(scene_, "/a", "mesh", {{"transform", moving(points(), points())}}));
  expect_all_back("of another type", set(scene_, "/a", "mesh", {{"transform:samples", moving(points(), points())}}));
}

TEST_F(DoorReleases, FaultyFramesRelease) {
  int32_t width = 0, height = 0;
  const auto a = frame();
  expect_all_back("frame_size", api().frame_size(delegate_, &a, &width, &height));
  const auto b = frame();
  expect_all_back("scene_write", api().scene_write(scene_, "a.alab", &b, parameters(), 2));
  const auto c = frame();
  expect_all_back("pass_start", api().pass_start(nullptr, &c));
}

TEST_F(DoorReleases, CallsOfDelegatesRelease) {
  const auto hear = [](void*, const char*, const AlabasterValue*) {};
  expect_all_back("command", api().command(nullptr, "dumpScene", parameters(), 2, hear, nullptr));
  expect_all_back("command", api().command(delegate_, nullptr, parameters(), 2, hear, nullptr));
  expect_all_back("command", api().command(delegate_, "dumpScene", parameters(), 2, nullptr, nullptr));
  const auto a = floats();
  expect_all_back("set_setting", api().set_setting(delegate_, nullptr, &a));
  const auto b = floats();
  expect_all_back("set_setting", api().set_setting(nullptr, "samples", &b));
}

// Memory that the library keeps comes back once it is replaced; copied memory comes back at once.
TEST_F(DoorReleases, ReplacedPrimsReleaseOnce) {
  for (size_t kind = 0; kind < 6; ++kind) {
    std::vector<Prim> all = prims();
    const Prim& prim = all[kind];
    given_ = released_ = 0;
    for (const AlabasterParameter& field : prim.fields) given_ += lent_with(field.value);
    ASSERT_EQ(set(scene_, "/a", prim.kind, prim.fields), ALABASTER_OK) << api().last_error();
    EXPECT_LE(released_, given_) << prim.kind;
    ASSERT_EQ(set(scene_, "/a", prim.kind), ALABASTER_OK) << api().last_error();
    EXPECT_EQ(released_, given_) << prim.kind;
  }
}

// Once memory suffices, the mesh is there, and its arrays come back with the scene.
TEST_F(DoorReleases, CallsWithoutMemoryRelease) {
  api().delegate_destroy(std::exchange(delegate_, nullptr));
  api().pass_destroy(std::exchange(pass_, nullptr));
  api().buffer_destroy(std::exchange(color_, nullptr));
  for (size_t allowed = 0;; ++allowed) {
    ASSERT_LT(allowed, 1000u);
    const Fields a = mesh();
    AlabasterStatus status = ALABASTER_OK;
    {
      const testing::FailingMemory memory(allowed);
      status = api().scene_set(scene_, "/a", "mesh", a.data(), a.size());
    }
    if (status == ALABASTER_OK) break;
    EXPECT_EQ(status, ALABASTER_OUT_OF_MEMORY);
    expect_all_back("scene_set", status);
  }
  EXPECT_LT(released_, given_);
  api().scene_destroy(std::exchange(scene_, nullptr));
  EXPECT_EQ(released_, given_);
}

TEST_F(DoorReleases, EditThatMemoryDoesNotHoldReleases) {
  const std::vector<float> before = render();
  const auto aside = at(50);
  for (size_t allowed = 0;; ++allowed) {
    ASSERT_LT(allowed, 1000u);
    const Fields fields = {{"transform", lent(matrix(aside))},
                           {"primvars:st", lent(array(ALABASTER_FLOAT2, kNumbers, 4))},
                           {"primvars:points:samples", moving(points(), points())}};
    AlabasterStatus status = ALABASTER_OK;
    {
      const testing::FailingMemory memory(allowed);
      status = api().scene_edit(scene_, "/quad", fields.data(), fields.size());
    }
    if (status == ALABASTER_OK) break;
    EXPECT_EQ(status, ALABASTER_OUT_OF_MEMORY);
    expect_all_back("scene_edit", status);
    if (allowed % 4 == 0) {
      ASSERT_EQ(render(), before) << allowed << ": nothing is changed";
    }
  }
  EXPECT_EQ(centre(render())[3], 0);
}

}  // namespace
}  // namespace alabaster::c_api_testing
