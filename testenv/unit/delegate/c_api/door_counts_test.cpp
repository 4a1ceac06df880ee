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

namespace alabaster::c_api_testing {
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
  AlabasterStatus record(size_t AlabasterRecordOptions::*count) {
    EXPECT_EQ(set(scene_, "/settings", "renderSettings"), ALABASTER_OK);
    auto options = sized<AlabasterRecordOptions>();
    options.*count = kMany;
    return api().record(delegate_, &options, nullptr, nullptr);
  }
  AlabasterStatus start(size_t AlabasterFrame::*count) {
    auto frame = sized<AlabasterFrame>();
    frame.*count = kMany;
    return api().pass_start(pass_, &frame);
  }
  std::vector<Pair> pairs();
};

std::vector<Pair> DoorCounts::pairs() {
  return {
      {"AlabasterValue.count", [this] { return set_quad(array(ALABASTER_FLOAT3, nullptr, kMany)); }},
      {"scene_set.count", [this] { return api().scene_set(scene_, "/a", "mesh", nullptr, kMany); }},
      {"scene_edit.count", [this] { return api().scene_edit(scene_, "/quad", nullptr, kMany); }},
      {"scene_edit_instances.count", [this] { return api().scene_edit_instances(scene_, "/many", 0, nullptr, kMany); }},
      {"set_settings.count", [this] { return api().set_settings(delegate_, nullptr, kMany); }},
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
      {"AlabasterFrame.binding_count", [this] { return start(&AlabasterFrame::binding_count); }},
      {"AlabasterFrame.free_camera_count", [this] { return start(&AlabasterFrame::free_camera_count); }},
      {"AlabasterRecordOptions.file_count", [this] { return record(&AlabasterRecordOptions::file_count); }},
      {"AlabasterRecordOptions.aov_count", [this] { return record(&AlabasterRecordOptions::aov_count); }},
      {"command.count",
       [this] {
         return api().command(
             delegate_, "dumpScene", nullptr, kMany, [](void*, const char*, const AlabasterValue*) {}, nullptr);
       }},
      {"scene_write.count", [this] { return api().scene_write(scene_, "a.alab", nullptr, nullptr, kMany); }},
  };
}

TEST_F(DoorCounts, CountsWithoutArraysAreRefused) {
  for (const Pair& pair : pairs()) {
    EXPECT_EQ(pair.call(), ALABASTER_INVALID_ARGUMENT) << pair.where;
    EXPECT_NE(std::string(api().last_error()).find("null"), std::string::npos) << pair.where << api().last_error();
  }
}

// Read in the header, so that a pair that is added there is missed here.
TEST_F(DoorCounts, AllCountsAreVisited) {
  std::set<std::string> visited = {"AlabasterSetting.choice_count", "AlabasterPick.instance_count"};  // in answers
  for (const Pair& pair : pairs()) visited.insert(pair.where);
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
  EXPECT_GT(found.size(), 10u);
  EXPECT_EQ(found, visited);
}

TEST_F(DoorCounts, CountsBeyondAnyMemoryAreRefused) {
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
  auto frame = sized<AlabasterFrame>();
  frame.width = frame.height = kSide;
  int32_t width = 0, height = 0;
  const auto call = [&](size_t size) {
    frame.size = size;
    return api().frame_size(delegate_, &frame, &width, &height);
  };
  for (const size_t size : {size_t(0), size_t(12), sizeof frame - 4, sizeof frame - 8, sizeof frame + 4}) {
    EXPECT_EQ(call(size), ALABASTER_INVALID_ARGUMENT) << size;
    EXPECT_NE(std::string(api().last_error()).find("`size`"), std::string::npos) << api().last_error();
  }
  for (const size_t size : {sizeof frame, sizeof frame + 8}) EXPECT_EQ(call(size), ALABASTER_OK) << size;
}

}  // namespace
}  // namespace alabaster::c_api_testing
