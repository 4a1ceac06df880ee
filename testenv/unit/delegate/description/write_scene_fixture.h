// Scenes that are written, and read again: both pictures.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "delegate/description/render_description.h"
#include "delegate/description/write_scene.h"
#include "testenv/support/stage.h"

namespace alabaster::hd::description {

class WriteSceneTest : public ::testing::Test {
 protected:
  static constexpr int kWidth = 24, kHeight = 16;
  using Pixels = std::vector<float>;

  WriteSceneTest() {
    folder_ = std::filesystem::temp_directory_path() / ("write_scene_" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
    state_.camera = "/camera";
    state_.framing.displayMax = {float(kWidth), float(kHeight)};
    state_.framing.dataWindow = {0, 0, kWidth, kHeight};
  }
  ~WriteSceneTest() override { std::filesystem::remove_all(folder_); }

  std::string file(const std::string& name = "copy.json") const { return (folder_ / name).string(); }
  bool is_empty() const { return std::filesystem::is_empty(folder_); }

  std::string write() { return WriteScene(file(), stage_.scene, state_, settings_); }
  nlohmann::json document(const std::string& name = "copy.json") const {
    return nlohmann::json::parse(std::ifstream(file(name)));
  }

  static Pixels picture(Stage& stage, RenderPassState state, const std::map<Token, Value>& settings) {
    for (const auto& [name, value] : settings) stage.delegate->SetRenderSetting(name, value);
    const Rect2i& window = state.framing.dataWindow;
    RenderBuffer* const color = stage.add_buffer("/color", window.width(), window.height(), Format::float32vec4);
    state.aovBindings = {{"color", color, {}}};
    stage.index->SyncAll();
    const auto pass = stage.delegate->CreateRenderPass();
    EXPECT_TRUE(Stage::finish(*pass, state));
    return Stage::pixels<float>(color);
  }
  Pixels picture() { return picture(stage_, state_, settings_); }

  /// The picture of a file, of its own camera, window and settings.
  static Pixels picture_of(const std::string& description) {
    Stage stage;
    LoadOptions options;
    options.allow_outside = true;
    const SceneFile loaded = LoadScene(
        description, &stage.scene, [](const Diagnostic& d) { ADD_FAILURE() << d.where << ": " << d.text; }, options);
    if (!loaded.ok) return {};
    EXPECT_TRUE(loaded.notes.empty()) << "nothing is added";
    const RenderSettingsDescription settings = stage.scene.GetRenderSettings(loaded.settings);
    RenderPassState state;
    state.camera = settings.camera;
    state.windowPolicy = settings.windowPolicy;
    const Vec2f corner(float(settings.window().minX), float(settings.window().minY));
    state.framing.displayMin = -corner;
    state.framing.displayMax = Vec2f(float(settings.width), float(settings.height)) - corner;
    state.framing.dataWindow = {0, 0, settings.window().width(), settings.window().height()};
    state.framing.pixelAspectRatio = settings.pixelAspectRatio;
    return picture(stage, state, {});
  }

  /// Writes the scene, and expects the same picture of the files.
  void expect_same_picture() {
    ASSERT_EQ(write(), "");
    const Pixels before = picture(), after = picture_of(file());
    ASSERT_EQ(before.size(), after.size());
    size_t differ = 0;
    float largest = 0;
    for (size_t i = 0; i < before.size(); ++i) {
      differ += before[i] != after[i];
      largest = std::max(largest, std::abs(before[i] - after[i]));
    }
    EXPECT_EQ(differ, 0u) << "of " << before.size() << " numbers, by " << largest;
    EXPECT_GT(*std::max_element(before.begin(), before.end()), 0) << "there is something to compare";
  }

  std::filesystem::path folder_;
  Stage stage_;
  RenderPassState state_;
  std::map<Token, Value> settings_{{"samples", int64_t(4)}, {"threads", 2}};
};

}  // namespace alabaster::hd::description
