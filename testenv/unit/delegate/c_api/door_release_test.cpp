// Arrays that are lent come back once, whatever fails.
#include <deque>

#include "testenv/support/failing_memory.h"
#include "testenv/unit/delegate/c_api/door_fixture.h"

namespace alabaster::door_testing {
namespace {

constexpr float kNumbers[64] = {};
constexpr int32_t kInts[4] = {0, 1, 2, 3};
constexpr double kMatrices[32] = {};

/// Everything that can lend something lends it here, and counts what comes back.
class DoorReleases : public Door {
 protected:
  AlabasterValue lent(int32_t type, const void* data, size_t count) {
    ++given_;
    return {type, 1, data, count, &count_release, &released_};
  }
  AlabasterValue floats() { return lent(ALABASTER_FLOAT, kNumbers, 4); }
  AlabasterValue ints() { return lent(ALABASTER_INT, kInts, 4); }
  AlabasterMotion moving(int32_t type, const void* data, size_t count) {
    samples_.push_back({lent(type, data, count), lent(type, data, count)});
    static constexpr double kTimes[] = {0, 1};
    return {kTimes, samples_.back().data(), 2};
  }
  AlabasterMotion moving_matrix() {
    const AlabasterMotion motion = moving(ALABASTER_MATRIX, kMatrices, 1);
    for (AlabasterValue& value : samples_.back()) value.is_array = 0;
    return motion;
  }
  AlabasterPrimvar primvar(const char* name) {
    return {name,
            nullptr,
            ALABASTER_VERTEX,
            lent(ALABASTER_FLOAT3, kNumbers, 4),
            ints(),
            moving(ALABASTER_FLOAT3, kNumbers, 4)};
  }
  AlabasterMesh mesh() {
    AlabasterMesh made = {};
    made.size = sizeof made;
    made.face_vertex_counts = ints(), made.face_vertex_indices = ints(), made.hole_indices = ints();
    primvars_ = {primvar("points"), primvar("normals")};
    made.primvars = primvars_.data(), made.primvar_count = primvars_.size();
    subset_ = {"a", "/b", ints()};
    made.subsets = &subset_, made.subset_count = 1;
    tags_ = {};
    tags_.size = sizeof tags_;
    tags_.crease_indices = ints(), tags_.crease_lengths = ints(), tags_.crease_weights = floats();
    tags_.corner_indices = ints(), tags_.corner_weights = floats();
    made.subdiv_tags = &tags_;
    made.motion = moving_matrix();
    return made;
  }
  AlabasterInstancer instancer() {
    AlabasterInstancer made = {};
    made.size = sizeof made;
    primvars_ = {primvar("hydra:instanceTranslations")};
    made.primvars = primvars_.data(), made.primvar_count = 1;
    prototype_ = {"/quad", ints()};
    made.prototypes = &prototype_, made.prototype_count = 1;
    made.motion = moving_matrix();
    return made;
  }
  const AlabasterParameter* parameters() {
    parameters_ = {{"a", floats()}, {"b", ints()}};
    return parameters_.data();
  }
  AlabasterMaterial material() {
    node_ = {"surface", "AlabasterDisney", parameters(), 2, nullptr, 0};
    return {sizeof(AlabasterMaterial), &node_, 1, nullptr, nullptr};
  }
  AlabasterCamera camera() { return {sizeof(AlabasterCamera), nullptr, parameters(), 2, moving_matrix()}; }
  AlabasterFrame frame() {
    AlabasterFrame made = {};
    made.size = sizeof made;
    free_camera_ = camera();
    made.free_camera = &free_camera_;
    made.roots = ints();  // of the wrong type
    return made;
  }

  /// After `call`, which fails.
  void expect_all_back(const char* what, AlabasterStatus status) {
    EXPECT_NE(status, ALABASTER_OK) << what;
    EXPECT_GT(given_, 0) << what;
    EXPECT_EQ(released_, given_) << what;
    released_ = given_ = 0;
    samples_.clear();
  }

  int given_ = 0, released_ = 0;
  std::deque<std::array<AlabasterValue, 2>> samples_;
  std::vector<AlabasterPrimvar> primvars_;
  std::vector<AlabasterParameter> parameters_;
  AlabasterSubset subset_ = {};
  AlabasterSubdivTags tags_ = {};
  AlabasterPrototype prototype_ = {};
  AlabasterNode node_ = {};
  AlabasterCamera free_camera_ = {};
};

TEST_F(DoorReleases, ComeFromCallsWithoutASceneOrAPath) {
  for (const char* path : {static_cast<const char*>(nullptr), "", "/a"}) {
    AlabasterScene* const scene = path && *path ? nullptr : scene_;
    const auto a = mesh();
    expect_all_back("set_mesh", api().set_mesh(scene, path, &a));
    const auto b = instancer();
    expect_all_back("set_instancer", api().set_instancer(scene, path, &b));
    const auto c = material();
    expect_all_back("set_material", api().set_material(scene, path, &c));
    const auto d = camera();
    expect_all_back("set_camera", api().set_camera(scene, path, &d));
    const AlabasterLight e = {sizeof e, "domeLight", nullptr, parameters(), 2, 0};
    expect_all_back("set_light", api().set_light(scene, path, &e));
    const AlabasterRenderSettings f = {sizeof f, nullptr, 0, 0, 0, {}, 0, parameters(), 2};
    expect_all_back("set_render_settings", api().set_render_settings(scene, path, &f));
    const auto g = primvar("points");
    expect_all_back("set_primvar", api().set_primvar(scene, path, &g));
    const auto h = primvar("points");
    expect_all_back("set_instance_values", api().set_instance_values(scene, path, &h, 0));
    const auto i = floats();
    expect_all_back("set_parameter", api().set_parameter(scene, path, "x", &i));
  }
}

TEST_F(DoorReleases, ComeFromStructsWithoutASize) {
  auto a = mesh();
  a.size = 0;
  expect_all_back("set_mesh", api().set_mesh(scene_, "/a", &a));
  auto b = mesh();
  tags_.size = 3;
  expect_all_back("its tags", api().set_mesh(scene_, "/a", &b));
  auto c = instancer();
  c.size = 0;
  expect_all_back("set_instancer", api().set_instancer(scene_, "/a", &c));
  auto d = material();
  d.size = 0;
  expect_all_back("set_material", api().set_material(scene_, "/a", &d));
  auto e = frame();
  free_camera_.size = 0;
  expect_all_back("pass_start", api().pass_start(pass_, &e));
  AlabasterDelegateOptions f = {0, nullptr, nullptr, parameters(), 2};
  expect_all_back("delegate_create", api().delegate_create(&f, nullptr, nullptr));
}

TEST_F(DoorReleases, ComeFromValuesAtFault) {
  auto a = mesh();
  primvars_[0].value.type = 77;
  expect_all_back("set_mesh", api().set_mesh(scene_, "/a", &a));
  EXPECT_STREQ(api().last_error(), "'points': there are no arrays of type 77");
  auto b = mesh();
  b.cull_style = 99;
  expect_all_back("cull_style", api().set_mesh(scene_, "/a", &b));
  auto c = material();
  c.surface = "elsewhere";
  expect_all_back("set_material", api().set_material(scene_, "/a", &c));
  const auto d = primvar("points");
  expect_all_back("set_primvar", api().set_primvar(scene_, "/nobody", &d));
  int32_t width = 0, height = 0;
  auto e = frame();
  expect_all_back("frame_size", api().frame_size(delegate_, &e, &width, &height));
  auto f = frame();
  expect_all_back("scene_write", api().scene_write(scene_, "a.json", &f, parameters(), 2));
  const auto g = frame();
  expect_all_back("pass_start", api().pass_start(nullptr, &g));
}

TEST_F(DoorReleases, ComeFromCallsOfDelegates) {
  const auto hear = [](void*, const char*, const AlabasterValue*) {};
  expect_all_back("command", api().command(nullptr, "dumpScene", parameters(), 2, hear, nullptr));
  expect_all_back("command", api().command(delegate_, nullptr, parameters(), 2, hear, nullptr));
  expect_all_back("command", api().command(delegate_, "dumpScene", parameters(), 2, nullptr, nullptr));
  const auto a = floats();
  expect_all_back("set_setting", api().set_setting(delegate_, nullptr, &a));
  const auto b = floats();
  expect_all_back("set_setting", api().set_setting(nullptr, "samples", &b));
}

// Once memory suffices, the mesh is there, and its arrays come back with the scene.
TEST_F(DoorReleases, ComeWhereMemoryRunsOut) {
  api().delegate_destroy(std::exchange(delegate_, nullptr));
  api().pass_destroy(std::exchange(pass_, nullptr));
  api().buffer_destroy(std::exchange(color_, nullptr));
  for (size_t allowed = 0;; ++allowed) {
    ASSERT_LT(allowed, 1000u);
    const auto a = mesh();
    AlabasterStatus status = ALABASTER_OK;
    {
      const testing::FailingMemory memory(allowed);
      status = api().set_mesh(scene_, "/a", &a);
    }
    if (status == ALABASTER_OK) break;
    EXPECT_EQ(status, ALABASTER_OUT_OF_MEMORY);
    expect_all_back("set_mesh", status);
  }
  EXPECT_LT(released_, given_);
  api().scene_destroy(std::exchange(scene_, nullptr));
  EXPECT_EQ(released_, given_);
}

}  // namespace
}  // namespace alabaster::door_testing
