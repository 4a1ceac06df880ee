// The options of a load are layers over the file's description, and each value keeps its origin for messages.
#include "delegate/support/lookup.h"
#include "testenv/unit/delegate/description/scene_fixture.h"

namespace alabaster::hd::description {
namespace {

class Layers : public SceneFiles {
 protected:
  const host::CameraDescription& camera(const SceneFile& file) const {
    return scene.GetCameras().at(scene.GetAllRenderSettings().at(file.settings).camera);
  }
  double setting(const SceneFile& file, const char* name) const {
    const Dictionary& all = scene.GetAllRenderSettings().at(file.settings).settings;
    return all.contains(name) ? all.at(name).number_or(-1) : -1;
  }
  void expect_error(const std::string& text, const LoadOptions& options, LoadCause cause, const std::string& said) {
    EXPECT_EQ(describe(text, options).cause, cause) << errors();
    EXPECT_NE(errors().find(said), std::string::npos) << "said: " << errors();
    EXPECT_EQ(diagnostics.size(), 1u) << errors();
  }
};

// promise: pipeline.layers
TEST_F(Layers, AChosenCameraComesOverTheFilesChangesAndBelowOverrides) {
  LoadOptions options = with_overrides({"camera.fStop=8"});
  options.camera = "front";
  const SceneFile file = describe(R"({"gltf": [{"file": "lit.gltf"}],
      "camera": {"lookAt": {"eye": [9, 9, 9], "target": [0, 0, 0]}, "fStop": 2, "focusDistance": 3}})",
                                  options);
  ASSERT_TRUE(file.ok) << errors();
  EXPECT_EQ(camera(file).transform.translation(), Vec3d(0, 0, 5));
  EXPECT_EQ(camera(file).parameters.at("fStop"), Value(8.0f));
  EXPECT_FALSE(camera(file).parameters.contains("focusDistance")) << "the file's change is meant for its own camera";
}

TEST_F(Layers, AnOverridesPlacementReplacesTheFiles) {
  const std::string moved =
      R"({"camera": {"motion": [{"time": 0, "transform": {}}, {"time": 1, "transform": {"translate": [1, 0, 0]}}]}})";
  const SceneFile file = describe(moved, with_overrides({R"(camera.lookAt={"eye": [0, 0, 4], "target": [0, 0, 0]})"}));
  ASSERT_TRUE(file.ok) << errors();
  EXPECT_EQ(camera(file).transform.translation(), Vec3d(0, 0, 4));
  EXPECT_TRUE(camera(file).transformSamples.values.empty());
  const SceneFile last = describe("{}", with_overrides({R"(camera.lookAt={"eye": [0, 0, 4], "target": [0, 0, 0]})",
                                                        R"(camera.transform={"translate": [0, 0, 6]})"}));
  ASSERT_TRUE(last.ok) << errors();
  EXPECT_EQ(camera(last).transform.translation(), Vec3d(0, 0, 6));
}

TEST_F(Layers, APresetComesOverTheLayersBelowItAndUnderThoseAboveIt) {
  const std::string text = R"({"settings": {"quality": "draft", "maxDepth": 3, "seed": 5}})";
  const SceneFile own = describe(text);
  EXPECT_EQ(setting(own, "maxDepth"), 3) << "the file's own setting beside its preset";
  EXPECT_EQ(setting(own, "samples"), 65536);
  const SceneFile over = describe(text, with_overrides({"maxDepth=4", "quality=preview", "samples=9"}));
  EXPECT_EQ(setting(over, "maxDepth"), 12) << "of the preset, which comes later";
  EXPECT_EQ(setting(over, "samples"), 9);
  EXPECT_EQ(setting(over, "seed"), 5);
}

// promise: pipeline.layers
TEST_F(Layers, ErrorsNameTheOptionOrTheLineThatSetTheValue) {
  const std::string file =
      "{\n\"camera\": {\"shutterOpen\": 0.5,\n\"shutterClose\": 0.75}, \"settings\":\n{\"crop\": [0, 0, 0, 4]}}";
  expect_error(file, {}, LoadCause::input, "scene.json:4 /settings/crop: The crop is empty");
  const auto with = [](const Override& one) { return with_overrides({Override("crop=[0,0,4,4]"), one}); };
  expect_error(file, with("camera.shutterClose=0.25"), LoadCause::option,
               "camera.shutterClose=0.25: The shutter closes before it opens");
  expect_error(file, with("camera.shutterOpen=0.9"), LoadCause::input,
               "scene.json:3 /camera/shutterClose: The shutter closes before it opens");
  expect_error(file, with({"--spp 0", "samples", int32_t(0)}), LoadCause::option,
               "--spp 0: 'samples' must be a whole number from 1");
  expect_error(file, with({"--crop", "crop", Array<int32_t>{1, 1, 1, 1}}), LoadCause::option,
               "--crop: The crop is empty");
  expect_error(file, with("samplse=3"), LoadCause::option, "samplse=3: Unknown key 'samplse'. Did you mean 'samples'?");
  expect_error(file, with("resolution=[0, 4]"), LoadCause::option,
               "resolution=[0, 4]: An entry of 'resolution' must be a whole number from 1");
  expect_error(file, with("lights/sun.intensity=1"), LoadCause::option,
               "lights/sun.intensity=1: No light matches 'sun'");
}

TEST_F(Layers, NumbersAreNamesOfNoSetting) {
  for (const char* one : {"999999999999=1", "camera.999999999999=1", "-=1", "camera.-=1", "a~b=1"})
    expect_error("{}", with_overrides({one}), LoadCause::option, std::string(one) + ": Unknown key");
}

TEST_F(Layers, APlaceThatIsNoneNamesTheNearestOne) {
  const std::pair<const char*, const char*> places[] = {
      {"settings.samples", "Did you mean 'samples'?"},
      {"render.samlpes", "Did you mean 'samples'?"},
      {"renderer/samples", "Did you mean 'samples'?"},
      {"renderer.x", "write SETTING=value"},
      {"renderer.x", "'renderer.x' cannot be set"},
      {".", "'.' cannot be set"},
      {"a.b/c", "'a.b/c' cannot be set"},
      {"Camera.fStop", "Did you mean 'camera.fStop'?"},
      {"camera/main.fStop", "Did you mean 'camera.fStop'?"},
      {"material/skin.roughness", "Did you mean 'materials/skin.roughness'?"},
      {"materials.skin.roughness", "Did you mean 'materials/skin.roughness'?"},
      {"light/a/b.intensity", "Did you mean 'lights/a/b.intensity'?"},
      {"mesh.refineLevel", "Did you mean 'meshes/NAME.refineLevel'?"},
      {"products/0.file", "the same for meshes and lights.\n"},
      {"camera", "write camera.parameter=value"},
      {"camera.", "write camera.parameter=value"},
      {"lights", "write lights/NAME.parameter=value"},
      {"lights/key", "write lights/NAME.parameter=value"},
      {"lights/.x", "write lights/NAME.parameter=value"},
      {"lights/key.", "write lights/NAME.parameter=value"},
  };
  for (const auto& [place, said] : places)
    expect_error("{}", with_overrides({std::string(place) + "=1"}), LoadCause::option, said);
}

TEST_F(Layers, MessagesNameOptionsAsTheHostWritesThem) {
  const auto set = [](const auto& change) {
    LoadOptions options;
    change(&options);
    return options;
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::tuple<LoadOptions, const char*, const char*> cases[] = {
      {set([](LoadOptions* o) { o->camera = "none"; }), "camera=none: No camera", "--camera none: No camera"},
      {set([](LoadOptions* o) {
         o->shutter = {1, 0};
       }),
       "shutter: The shutter", "--shutter: The shutter"},
      {set([&](LoadOptions* o) {
         o->shutter = {0, nan};
       }),
       "shutter: It is not a finite", "--shutter: It is not"},
      {set([&](LoadOptions* o) { o->time = nan; }), "time: It is not a finite", "--time: It is not a finite"},
      {set([](LoadOptions* o) {
         o->crop = {{1, 1, 1, 1}};
       }),
       "crop: The crop is empty", "--crop: The crop is empty"},
  };
  for (auto [options, argument, flag] : cases) {
    expect_error("{}", options, LoadCause::option, argument);
    EXPECT_EQ(errors().find("--"), std::string::npos) << errors();
    options.are_flags = true;
    expect_error("{}", options, LoadCause::option, flag);
  }
  EXPECT_EQ(describe("{}").notes.back().find("--"), std::string::npos) << describe("{}").notes.back();
}

TEST_F(Layers, AnOptionOfAnotherTypeReplacesTheFilesValue) {
  const SceneFile file = describe("{\"settings\": {\"resolution\": [8, 6], \"crop\": [0, 0, 4, 4]}}",
                                  with_overrides({Override("--size 20x10", "resolution", Vec2i(20, 10))}));
  ASSERT_TRUE(file.ok) << errors();
  EXPECT_EQ(scene.GetAllRenderSettings().at(file.settings).width, 20);
}

// promise: pipeline.layers
TEST_F(Layers, SizeAndCropComeOverThoseOfAllProducts) {
  const std::string text = R"({"settings": {"resolution": [16, 12], "crop": [0, 0, 8, 8]},
      "products": [{"file": "a.exr"}, {"file": "b.exr", "resolution": [8, 6]}, {"file": "c.exr", "crop": [1, 1, 4, 4]}]})";
  const auto forget = [this] {
    for (const Path& path : support::keys_of(scene.GetAllRenderSettings())) scene.Remove(path);
  };
  EXPECT_EQ(describe(text).further_settings.size(), 2u);
  forget();
  LoadOptions options = with_overrides({"resolution=[2, 2]"});
  options.size = Vec2i(20, 10);
  const SceneFile sized = describe(text, options);
  ASSERT_TRUE(sized.ok) << errors();
  ASSERT_EQ(sized.further_settings.size(), 1u) << "a render for each crop";
  for (const Path& path : {sized.settings, sized.further_settings[0]})
    EXPECT_EQ(scene.GetAllRenderSettings().at(path).width, 20);
  EXPECT_EQ(scene.GetAllRenderSettings().at(sized.further_settings[0]).crop, (Rect2i{1, 1, 4, 4}));
  options.crop = Rect2i{2, 2, 5, 5};
  forget();
  const SceneFile cropped = describe(text, options);
  ASSERT_TRUE(cropped.ok) << errors();
  EXPECT_TRUE(cropped.further_settings.empty()) << "one render for all products";
  EXPECT_EQ(scene.GetAllRenderSettings().at(cropped.settings).products.size(), 3u);
  EXPECT_EQ(scene.GetAllRenderSettings().at(cropped.settings).crop, (Rect2i{2, 2, 5, 5}));
}

TEST_F(Layers, AShutterOfAnOverrideOpensLikeTheFiles) {
  LoadOptions options = with_overrides({"camera.shutterOpen=0", "camera.shutterClose=0.5"});
  const SceneFile file = load("lit.gltf", options);
  ASSERT_TRUE(file.ok) << errors();
  EXPECT_EQ(camera(file).parameters.at("shutterClose"), Value(0.5f));
}

TEST_F(Layers, OptionsForAFileThatIsNoDescriptionAreRefused) {
  const auto same = [](const std::string& name) { return name; };
  for (const char* text : {"", "[1]", "3", "{\"settings\": 3}", "{\"models\": 3}", "{\"models\": [{\"file\": 3}]}"})
    WithOptions(text, with_overrides({"samples=3", "camera.fStop=2", "lights/a.intensity=1"}), same);
  EXPECT_EQ(WithOptions("[1]", {}, same), "");
  EXPECT_EQ(WithOptions(R"({"settings":{"quality":"draft","seed":2}})", with_overrides({"samples=3"}), same),
            R"({"settings":{"quality":"draft","samples":3,"seed":2}})");
}

}  // namespace
}  // namespace alabaster::hd::description
