// Scenes that the C interface writes.
#include <unistd.h>

#include <filesystem>

#include "testenv/unit/delegate/c_api/door_fixture.h"

namespace alabaster::c_api_testing {
namespace {

class DoorWrite : public Door {
 protected:
  DoorWrite() { std::filesystem::create_directories(folder_); }
  ~DoorWrite() override { std::filesystem::remove_all(folder_); }

  std::string file(const char* name) const { return (folder_ / name).string(); }
  AlabasterStatus write(const char* name, const char* camera = "/camera") {
    const AlabasterValue samples = whole(samples_);
    const AlabasterParameter settings[] = {{"samples", samples}};
    AlabasterFrame frame = {};
    frame.size = sizeof frame;
    frame.camera = camera;
    frame.width = frame.height = kSide;
    return api().scene_write(scene_, file(name).c_str(), &frame, settings, 1);
  }

  const int32_t samples_ = 4;
  const std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("door_write_" + std::to_string(getpid()));
};

// promise: pipeline.archive.scene_write
TEST_F(DoorWrite, LoadsAsTheSamePicture) {
  ASSERT_EQ(write("copy.alab"), ALABASTER_OK) << api().last_error();
  const std::vector<float> before = render();
  ASSERT_EQ(api().scene_clear(scene_), ALABASTER_OK);
  AlabasterLoaded loaded = {};
  loaded.size = sizeof loaded;
  ASSERT_EQ(api().scene_load(scene_, file("copy.alab").c_str(), nullptr, &loaded), ALABASTER_OK) << api().last_error();
  EXPECT_STREQ(loaded.notes, "");
  EXPECT_EQ(render(), before);
  EXPECT_EQ(api().scene_write(scene_, file("again.alab").c_str(), nullptr, nullptr, 0), ALABASTER_OK)
      << "by its own render settings";
}

TEST_F(DoorWrite, TakesTheCameraOfTheFramesOwnRenderSettings) {
  const AlabasterParameter width = {"width", whole(kSide)}, height = {"height", whole(kSide)};
  ASSERT_EQ(set(scene_, "/a", "renderSettings", {{"camera", path("/camera")}, width, height}), ALABASTER_OK);
  ASSERT_EQ(set(scene_, "/b", "renderSettings", {width, height}), ALABASTER_OK);
  AlabasterFrame frame = {};
  frame.size = sizeof frame;
  frame.settings = "/b";
  EXPECT_EQ(api().scene_write(scene_, file("copy.alab").c_str(), &frame, nullptr, 0), ALABASTER_OUTPUT_FAILED);
  EXPECT_NE(std::string(api().last_error()).find("has no camera"), std::string::npos) << api().last_error();
  frame.settings = "/a";
  EXPECT_EQ(api().scene_write(scene_, file("copy.alab").c_str(), &frame, nullptr, 0), ALABASTER_OK);
}

TEST_F(DoorWrite, SaysWhyItFails) {
  EXPECT_EQ(write("copy.alab", "/gone"), ALABASTER_OUTPUT_FAILED);
  EXPECT_STREQ(api().last_error(), "/gone is no camera of the scene; name one that is");
  EXPECT_EQ(write("copy.txt"), ALABASTER_OUTPUT_FAILED);
  EXPECT_NE(std::string(api().last_error()).find("must end in .alab"), std::string::npos);
  EXPECT_EQ(write("no/copy.alab"), ALABASTER_OUTPUT_FAILED);
  EXPECT_NE(std::string(api().last_error()).find("there is no folder"), std::string::npos);
  EXPECT_TRUE(std::filesystem::is_empty(folder_));
  const AlabasterFrame frame = {};
  EXPECT_EQ(api().scene_write(scene_, "copy.alab", &frame, nullptr, 0), ALABASTER_INVALID_ARGUMENT) << "without a size";
  EXPECT_EQ(api().scene_write(scene_, nullptr, nullptr, nullptr, 0), ALABASTER_INVALID_ARGUMENT);
  EXPECT_EQ(api().scene_write(nullptr, "copy.alab", nullptr, nullptr, 0), ALABASTER_INVALID_ARGUMENT);
  EXPECT_EQ(api().scene_write(scene_, "copy.alab", nullptr, nullptr, 1), ALABASTER_INVALID_ARGUMENT);
}

}  // namespace
}  // namespace alabaster::c_api_testing
