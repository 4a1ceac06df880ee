// The scenes of testenv/scenes, written and read again.
#include "testenv/support/build_paths.h"
#include "testenv/unit/delegate/description/write_scene_fixture.h"

namespace alabaster::hd::description {
namespace {

class WriteSceneOfFile : public WriteSceneTest, public ::testing::WithParamInterface<const char*> {
 protected:
  void load(const std::string& name) {
    LoadOptions options;
    options.overrides = {"resolution=[24,16]"};
    const SceneFile loaded = LoadScene(
        testing::source_file("testenv/scenes/") + name, &stage_.scene,
        [](const Diagnostic& d) { ADD_FAILURE() << d.where << ": " << d.text; }, options);
    ASSERT_TRUE(loaded.ok);
    const RenderSettingsDescription settings = stage_.scene.GetRenderSettings(loaded.settings);
    state_.camera = settings.camera;
    state_.windowPolicy = settings.windowPolicy;
    for (const auto& [key, value] : settings.settings) settings_.emplace(key, value);
  }
};

TEST_P(WriteSceneOfFile, HasTheSamePicture) {
  load(GetParam());
  expect_same_picture();
}

INSTANTIATE_TEST_SUITE_P(Scenes, WriteSceneOfFile,
                         ::testing::Values("backlit/backlit.json", "lights/lights.json", "sample/sample.json",
                                           "hard_light/hard_light.json", "thick_thin/thick_thin.json",
                                           "skin_closeup/skin_closeup.json", "still_life/still_life.json",
                                           "mixed_no_subsurface/mixed_no_subsurface.json",
                                           "dome_high_contrast/dome_high_contrast.json"));

}  // namespace
}  // namespace alabaster::hd::description
