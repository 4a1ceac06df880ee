// A count without its array is refused, in every struct and function of the header.
#include <algorithm>
#include <fstream>
#include <functional>
#include <limits>
#include <regex>
#include <set>
#include <sstream>

#include "testenv/support/build_paths.h"
#include "testenv/unit/delegate/c_api/door_fixture.h"

namespace alabaster::door_testing {
namespace {

constexpr size_t kMany = 3;

/// One pair: the struct or function and the member that counts, and a call that has the count alone.
struct Pair {
  const char* where;
  std::function<AlabasterStatus()> call;
};

template <class T>
T sized() {
  T made = {};
  made.size = sizeof made;
  return made;
}

class DoorCounts : public Door {
 protected:
  AlabasterStatus set_mesh(const std::function<void(AlabasterMesh&)>& change) {
    auto mesh = sized<AlabasterMesh>();
    change(mesh);
    return api().set_mesh(scene_, "/a", &mesh);
  }
  AlabasterStatus set_node(const AlabasterNode& node) {
    auto material = sized<AlabasterMaterial>();
    material.nodes = &node, material.node_count = 1;
    return api().set_material(scene_, "/a", &material);
  }
  AlabasterStatus set_instancer(const std::function<void(AlabasterInstancer&)>& change) {
    auto instancer = sized<AlabasterInstancer>();
    change(instancer);
    return api().set_instancer(scene_, "/a", &instancer);
  }
  template <class T>
  AlabasterStatus set_prim(AlabasterStatus (*set)(AlabasterScene*, const char*, const T*), size_t T::*count) {
    auto prim = sized<T>();
    prim.*count = kMany;
    if constexpr (std::is_same_v<T, AlabasterLight>) prim.type = "domeLight";
    return set(scene_, "/a", &prim);
  }
  AlabasterStatus record(size_t AlabasterRecordOptions::*count) {
    const auto settings = sized<AlabasterRenderSettings>();
    EXPECT_EQ(api().set_render_settings(scene_, "/settings", &settings), ALABASTER_OK);
    auto options = sized<AlabasterRecordOptions>();
    options.*count = kMany;
    return api().record(delegate_, &options, nullptr, nullptr);
  }
  std::vector<Pair> pairs();
  std::vector<Pair> pairs_of_calls();
};

std::vector<Pair> DoorCounts::pairs() {
  const AlabasterValue bare = array(ALABASTER_FLOAT3, nullptr, kMany);
  return {
      {"AlabasterValue.count", [=, this] { return set_quad(bare); }},
      {"AlabasterMotion.count", [=, this] { return set_mesh([](auto& mesh) { mesh.motion.count = kMany; }); }},
      {"AlabasterMesh.primvar_count", [=, this] { return set_mesh([](auto& mesh) { mesh.primvar_count = kMany; }); }},
      {"AlabasterMesh.subset_count", [=, this] { return set_mesh([](auto& mesh) { mesh.subset_count = kMany; }); }},
      {"AlabasterInstancer.primvar_count",
       [=, this] { return set_instancer([](auto& instancer) { instancer.primvar_count = kMany; }); }},
      {"AlabasterInstancer.prototype_count",
       [=, this] { return set_instancer([](auto& instancer) { instancer.prototype_count = kMany; }); }},
      {"AlabasterNode.parameter_count",
       [=, this] {
         return set_node({"surface", "AlabasterDisney", nullptr, kMany, nullptr, 0});
       }},
      {"AlabasterNode.connection_count",
       [=, this] {
         return set_node({"surface", "AlabasterDisney", nullptr, 0, nullptr, kMany});
       }},
      {"AlabasterMaterial.node_count",
       [=, this] { return set_prim(api().set_material, &AlabasterMaterial::node_count); }},
      {"AlabasterLight.parameter_count",
       [=, this] { return set_prim(api().set_light, &AlabasterLight::parameter_count); }},
      {"AlabasterCamera.parameter_count",
       [=, this] { return set_prim(api().set_camera, &AlabasterCamera::parameter_count); }},
      {"AlabasterRenderSettings.setting_count",
       [=, this] { return set_prim(api().set_render_settings, &AlabasterRenderSettings::setting_count); }},
  };
}

std::vector<Pair> DoorCounts::pairs_of_calls() {
  return {
      {"AlabasterLoadOptions.override_count",
       [this] {
         auto options = sized<AlabasterLoadOptions>();
         options.override_count = kMany;
         return api().scene_load(scene_, "a.json", &options, nullptr);
       }},
      {"AlabasterDelegateOptions.setting_count",
       [] {
         auto options = sized<AlabasterDelegateOptions>();
         options.setting_count = kMany;
         AlabasterDelegate* made = nullptr;
         const AlabasterStatus status = api().delegate_create(&options, nullptr, &made);
         api().delegate_destroy(made);
         return status;
       }},
      {"AlabasterFrame.binding_count",
       [this] {
         auto frame = sized<AlabasterFrame>();
         frame.binding_count = kMany;
         return api().pass_start(pass_, &frame);
       }},
      {"AlabasterRecordOptions.file_count", [this] { return record(&AlabasterRecordOptions::file_count); }},
      {"AlabasterRecordOptions.aov_count", [this] { return record(&AlabasterRecordOptions::aov_count); }},
      {"command.count",
       [this] {
         return api().command(
             delegate_, "dumpScene", nullptr, kMany, [](void*, const char*, const AlabasterValue*) {}, nullptr);
       }},
      {"scene_write.count", [this] { return api().scene_write(scene_, "a.json", nullptr, nullptr, kMany); }},
  };
}

TEST_F(DoorCounts, WithoutTheirArraysAreRefused) {
  std::vector<Pair> all = pairs();
  for (Pair& pair : pairs_of_calls()) all.push_back(std::move(pair));
  for (const Pair& pair : all) {
    EXPECT_EQ(pair.call(), ALABASTER_INVALID_ARGUMENT) << pair.where;
    EXPECT_NE(std::string(api().last_error()).find("null"), std::string::npos) << pair.where << api().last_error();
  }
}

// Read in the header, so that a pair that is added there is missed here.
TEST_F(DoorCounts, AreAllVisited) {
  std::set<std::string> visited = {"AlabasterSetting.choice_count", "AlabasterPick.instance_count"};  // in answers
  for (const Pair& pair : pairs()) visited.insert(pair.where);
  for (const Pair& pair : pairs_of_calls()) visited.insert(pair.where);
  const std::string folder = testing::source_file("delegate/c_api/");
  std::set<std::string> found;
  for (const char* header : {"alabaster_types.h", "alabaster.h"}) {
    std::ifstream file(folder + header);
    std::string line, where;
    while (std::getline(file, line)) {
      std::smatch match;
      if (std::regex_search(line, match, std::regex("^typedef struct (\\w+) \\{"))) where = match[1];
      if (std::regex_search(line, match, std::regex("AlabasterStatus \\(\\*(\\w+)\\)"))) where = match[1];
      if (std::regex_search(line, match, std::regex("size_t (\\w*count)\\b")))
        found.insert(where + "." + match[1].str());
    }
  }
  EXPECT_GT(found.size(), 15u);
  EXPECT_EQ(found, visited);
}

TEST_F(DoorCounts, BeyondAnyMemoryAreRefused) {
  const float one[3] = {};
  EXPECT_EQ(set_quad(array(ALABASTER_FLOAT3, one, ~size_t(0) / 8)), ALABASTER_INVALID_ARGUMENT);
  EXPECT_NE(std::string(api().last_error()).find("points"), std::string::npos) << api().last_error();
}

TEST_F(DoorCounts, WindowsAndRowsThatOverflowAreRefused) {
  constexpr int kLeast = std::numeric_limits<int>::min(), kMost = std::numeric_limits<int>::max();
  auto frame = sized<AlabasterFrame>();
  frame.window = {kLeast, kLeast, kMost, kMost};
  int32_t width = 0, height = 0;
  EXPECT_EQ(api().frame_size(delegate_, &frame, &width, &height), ALABASTER_INVALID_ARGUMENT);
  EXPECT_NE(std::string(api().last_error()).find("2^20"), std::string::npos) << api().last_error();

  AlabasterBuffer* buffer = nullptr;
  ASSERT_EQ(api().buffer_create(delegate_, 2, 2, ALABASTER_FLOAT32_4, &buffer), ALABASTER_OK);
  std::vector<float> pixels(16);
  auto memory = sized<AlabasterMemory>();
  memory.pixels = pixels.data(), memory.row_bytes = std::numeric_limits<size_t>::max();
  memory.width = memory.height = 2, memory.format = ALABASTER_FLOAT32_4;
  EXPECT_EQ(api().buffer_show(buffer, &memory), ALABASTER_INVALID_ARGUMENT);
  api().buffer_destroy(buffer);
}

TEST_F(DoorCounts, SizesThatNoHeaderHasAreRefused) {
  auto mesh = sized<AlabasterMesh>();
  for (const size_t size : {size_t(0), size_t(12), sizeof mesh - 4, offsetof(AlabasterMesh, render_tag) - 8}) {
    mesh.size = size;
    EXPECT_EQ(api().set_mesh(scene_, "/a", &mesh), ALABASTER_INVALID_ARGUMENT) << size;
    EXPECT_NE(std::string(api().last_error()).find("`size`"), std::string::npos) << api().last_error();
  }
  for (const size_t size : {offsetof(AlabasterMesh, render_tag), sizeof mesh, sizeof mesh + 8}) {
    mesh.size = size;
    EXPECT_EQ(api().set_mesh(scene_, "/a", &mesh), ALABASTER_OK) << size;
  }
}

}  // namespace
}  // namespace alabaster::door_testing
