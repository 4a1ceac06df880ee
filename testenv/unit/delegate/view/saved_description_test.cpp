// A description that the window saved loads as the scene that it showed.
#include "delegate/view/saved_description.h"

#include <nlohmann/json.hpp>

#include "delegate/support/lookup.h"
#include "delegate/view/light_placement.h"
#include "testenv/unit/delegate/description/scene_fixture.h"
#include "testenv/unit/delegate/view/row_of.h"

namespace alabaster::view {
namespace {

namespace fs = std::filesystem;
using hd::Path;
using hd::Value;
using hd::Vec3f;
using hd::description::SceneFile;
using hd::host::RetainedSceneDelegate;

const Path kBackdropMaterial = "/materials/studio_backdrop";

// The parameters of the surface whose node's path has this name in it.
std::map<hd::Token, Value> surface_of(const RetainedSceneDelegate& scene, const std::string& name) {
  for (const auto& [path, network] : scene.GetMaterials())
    if (path.str().find(name) != std::string::npos) return network.nodes.begin()->second.parameters;
  ADD_FAILURE() << name;
  return {};
}

class SavedDescription : public hd::description::SceneFiles {
 protected:
  /// Saves `scene`, which was loaded from `name`, with the changes that are set, as saved.json in `folder`, and loads
  /// that into `again`.
  void save_and_load(const std::string& name, const SceneFile& loaded, const std::string& to = "saved.json") {
    changes.scene = &scene, changes.loaded = &loaded, changes.scene_file = folder_ / name;
    const hd::DiagnosticSink sink = [this](const hd::Diagnostic& d) { diagnostics.push_back(d); };
    ASSERT_TRUE(WriteDescription(changes, folder_ / to, sink)) << errors();
    hd::description::LoadOptions options;
    options.allow_outside = fs::path(to).has_parent_path();
    file_again = LoadScene(folder_ / to, &again, sink, options);
    ASSERT_TRUE(file_again.ok) << errors();
  }

  void expect_same_materials() {
    for (const auto& [path, network] : scene.GetMaterials()) {
      if (path == kBackdropMaterial) continue;
      ASSERT_TRUE(again.GetMaterials().contains(path)) << path.str();
      EXPECT_EQ(again.GetMaterials().at(path), network) << path.str();
    }
  }
  void expect_same_lights() {
    double power = 0, power_again = 0;
    for (const auto& [path, light] : scene.GetLights()) {
      power += light.parameters.contains("intensity") ? light.parameters.at("intensity").number_or(1) : 1;
      if (!again.GetLights().contains(path)) {
        ADD_FAILURE() << path.str() << " is lost";
        continue;
      }
      const auto& other = again.GetLights().at(path);
      EXPECT_EQ(other.type, light.type) << path.str();
      EXPECT_EQ(other.transform, light.transform) << path.str();
      EXPECT_EQ(other.visible, light.visible) << path.str();
      for (const auto& [name, value] : light.parameters)
        if (!value.get<hd::AssetPath>() && !value.empty()) {
          ASSERT_TRUE(other.parameters.contains(name)) << path.str() << " " << name.str();
          EXPECT_EQ(other.parameters.at(name).to_string(), value.to_string()) << path.str() << " " << name.str();
        }
    }
    for (const auto& [path, light] : again.GetLights())
      power_again += light.parameters.contains("intensity") ? light.parameters.at("intensity").number_or(1) : 1;
    EXPECT_EQ(power_again, power) << "no light is added";
  }
  void expect_same_camera(const SceneFile& loaded) {
    const auto& settings = scene.GetAllRenderSettings().at(loaded.settings);
    const auto& settings_again = again.GetAllRenderSettings().at(file_again.settings);
    const hd::CameraDescription& wanted = changes.camera ? *changes.camera : scene.GetCameras().at(settings.camera);
    const hd::CameraDescription& camera = again.GetCameras().at(settings_again.camera);
    EXPECT_EQ(camera.transform, wanted.transform);
    for (const auto& [name, value] : wanted.parameters)
      EXPECT_EQ(camera.parameters.count(name) ? camera.parameters.at(name).to_string() : "absent", value.to_string())
          << name.str();
    EXPECT_EQ(settings_again.width, settings.width);
    EXPECT_EQ(settings_again.height, settings.height);
  }

  ViewChanges changes;
  RetainedSceneDelegate again;
  SceneFile file_again;
};

TEST_F(SavedDescription, AGltfFileWithEditsLoadsAsItWasShown) {
  const SceneFile loaded = load("lit.gltf");
  ASSERT_TRUE(loaded.ok) << errors();
  SceneEdits edits(&scene);
  ASSERT_EQ(edits.materials().size(), 1u);
  ASSERT_EQ(edits.lights().size(), 1u);
  ASSERT_EQ(edits.set(edits.materials()[0], row_of("disney_material", "scatterDistance"), Vec3f(0.1f, 0.3f, 0.7f)), "");
  ASSERT_EQ(edits.set(edits.materials()[0], row_of("disney_material", "roughness"), 0.1), "");
  ASSERT_EQ(edits.set(edits.lights()[0], row_of("lights", "intensity"), 12.34), "");
  changes.materials = edits.record().materials, changes.lights = edits.record().lights;
  changes.settings = {{"samples", int32_t(7)}, {"subsurface", std::string("diffusion")}};
  hd::CameraDescription camera = scene.GetCameras().begin()->second;
  camera.transform.setAxisAngle(hd::Vec3d(0.1, 1, 0.2).normalized(), 0.3);
  changes.camera = camera;
  save_and_load("lit.gltf", loaded);
  expect_same_materials();
  expect_same_lights();
  expect_same_camera(loaded);
  const auto& settings = again.GetAllRenderSettings().at(file_again.settings).settings;
  EXPECT_EQ(settings.at("samples").number_or(0), 7);
  EXPECT_EQ(settings.at("subsurface").text_or(""), "diffusion");
}

TEST_F(SavedDescription, LightsThatWereAddedOrPlacedAreWhereTheyWere) {
  const SceneFile loaded = load("lit.gltf");
  ASSERT_TRUE(loaded.ok) << errors();
  SceneEdits edits(&scene);
  hd::Matrix4d turned;
  turned.setAxisAngle(hd::Vec3d(0.1, 1, 0.2).normalized(), 0.3);
  turned.setTranslation(hd::Vec3d(0.1, 1.0 / 3, -2));
  ASSERT_EQ(edits.place(edits.lights()[0], turned), "");
  for (const char* type : kNewLights) edits.add_light(new_light(type, turned, hd::Vec3d(0.7), hd::Vec3d(0, 1, 0)));
  ASSERT_EQ(edits.set("/lights/rect", row_of("lights", "intensity"), 12.34), "");
  ASSERT_EQ(edits.place("/lights/rect", turned), "");
  changes.lights = edits.record().lights;
  save_and_load("lit.gltf", loaded);
  expect_same_lights();
  EXPECT_EQ(again.GetLights().size(), 1 + std::size(kNewLights));
}

// A studio stands by the first camera: it must stay there although the camera has moved.
TEST_F(SavedDescription, AStudioStaysWhereItWas) {
  const SceneFile loaded = load("patch.gltf");
  ASSERT_TRUE(loaded.ok) << errors();
  ASSERT_TRUE(scene.GetMeshes().contains("/studio/backdrop"));
  hd::CameraDescription camera = scene.GetCameras().begin()->second;
  camera.transform = camera.transform * hd::Matrix4d().setTranslation(hd::Vec3d(0.5, 0.25, 1));
  changes.camera = camera;
  save_and_load("patch.gltf", loaded);
  expect_same_materials();
  expect_same_lights();
  expect_same_camera(loaded);
  EXPECT_EQ(again.GetMeshes().size(), scene.GetMeshes().size()) << "one backdrop";
  EXPECT_EQ(surface_of(again, "studio_backdrop"), surface_of(scene, "studio_backdrop"));
  const hd::Path backdrop("/studio/backdrop");
  EXPECT_EQ(again.GetMeshes().at(backdrop), scene.GetMeshes().at(backdrop))
      << "not one that is made for the new camera";
}

TEST_F(SavedDescription, ADescriptionKeepsWhatItHas) {
  const SceneFile loaded = describe(R"({"gltf": [{"file": "lit.gltf", "transform": {"translate": [0, 1, 0]}}],
      "materials": [{"match": "skin", "set": {"roughness": 0.9, "ior": 1.4}}],
      "lights": [{"name": "key", "type": "rectLight", "width": 2, "intensity": 5,
                  "transform": {"translate": [0, 3, 1]}}],
      "camera": {"lookAt": {"eye": [0, 0.5, 9], "target": [0, 0, 0]}, "focalLength": 85},
      "settings": {"maxDepth": 3}})");
  ASSERT_TRUE(loaded.ok) << errors();
  SceneEdits edits(&scene);
  ASSERT_EQ(edits.set(edits.materials()[0], row_of("disney_material", "roughness"), 0.1), "");
  ASSERT_EQ(edits.set("/lights/key", row_of("lights", "width"), 0.5), "");
  changes.materials = edits.record().materials, changes.lights = edits.record().lights;
  save_and_load("scene.json", loaded);
  expect_same_materials();
  expect_same_lights();
  expect_same_camera(loaded);
  EXPECT_EQ(again.GetAllRenderSettings().at(file_again.settings).settings.at("maxDepth").number_or(0), 3);
}

// Lens and film in millimetres, back and forth through float.
TEST_F(SavedDescription, ALensIsKeptToTheBit) {
  const SceneFile loaded = load("lit.gltf");
  ASSERT_TRUE(loaded.ok) << errors();
  hd::CameraDescription camera = scene.GetCameras().begin()->second;
  for (const float length : {0.0853f, 0.05f, 0.1234567f, 3.3333333e-3f}) {
    camera.parameters["focalLength"] = length;
    camera.parameters["fStop"] = 2.8f;
    camera.parameters["focusDistance"] = 4.2f;
    changes.camera = camera;
    RetainedSceneDelegate fresh;
    save_and_load("lit.gltf", loaded);
    expect_same_camera(loaded);
    for (const hd::Path& path : hd::support::keys_of(again.GetMeshes())) again.Remove(path);
  }
}

TEST_F(SavedDescription, AnotherFolderNamesTheFilesFromThere) {
  fs::create_directories(folder_ / "out" / "deep");
  const SceneFile loaded = load("lit.gltf");
  ASSERT_TRUE(loaded.ok) << errors();
  save_and_load("lit.gltf", loaded, "out/deep/saved.json");
  EXPECT_EQ(again.GetMeshes().size(), scene.GetMeshes().size());
  bool told = false;
  for (const hd::Diagnostic& d : diagnostics) told = told || d.text.find("--allow-outside") != std::string::npos;
  EXPECT_TRUE(told);
}

// A window shows the scene with the changes of the command line.
// promise: pipeline.order.saved
TEST_F(SavedDescription, TheOptionsOfTheCommandLineAreKept) {
  const std::string image = write_image("sky.hdr");
  changes.options.overrides = {"materials/skin.roughness=0.7",
                               "materials/skin.baseColor=[0.1,0.2,0.3]",
                               "lights/key.intensity=3",
                               "quality=draft",
                               "samples=5",
                               "camera.fStop=4"};
  changes.options.dome = image + ",0.5";
  const SceneFile loaded = describe(R"({"gltf": [{"file": "lit.gltf"}],
      "materials": [{"match": "skin", "set": {"roughness": 0.9, "ior": 1.4}}],
      "lights": [{"name": "key", "type": "sphereLight"}, {"name": "dome", "type": "domeLight", "intensity": 9}],
      "camera": {"lookAt": {"eye": [0, 0.5, 9], "target": [0, 0, 0]}},
      "settings": {"maxDepth": 3, "samples": 9}})",
                                    changes.options);
  ASSERT_TRUE(loaded.ok) << errors();
  save_and_load("scene.json", loaded);
  expect_same_materials();
  expect_same_camera(loaded);
  EXPECT_EQ(again.GetAllRenderSettings().at(file_again.settings).settings,
            scene.GetAllRenderSettings().at(loaded.settings).settings);
  EXPECT_EQ(again.GetLights().at("/lights/key"), scene.GetLights().at("/lights/key"));
  EXPECT_EQ(again.GetLights().at("/lights/dome").parameters.at("intensity").number_or(-1), 0) << "it was replaced";
  const auto& dome = again.GetLights().at("/lights/dome_2").parameters;
  EXPECT_EQ(dome.at("intensity").number_or(0), 0.5);
  EXPECT_TRUE(fs::equivalent(dome.at("texture:file").get<hd::AssetPath>()->resolved, image));
}

TEST_F(SavedDescription, TheChoicesOfACommandLineAreKept) {
  std::string two = hd::description::patch_gltf(true, false);
  const auto replace = [&two](const std::string& from, const std::string& to) {
    two.replace(two.find(from), from.size(), to);
  };
  replace(R"([0, 0, 5]})", R"([0, 0, 5]}, {"name": "other", "camera": 0, "translation": [0, 0, 7]})");
  replace("[0,1]", "[0,1,2]");
  write("poses.gltf", two);
  write("grade.ocio", "ocio_profile_version: 1");
  changes.ocio = folder_ / "grade.ocio";
  changes.options.camera = "other", changes.options.dome = "0.2,0.3,0.4", changes.options.time = 1.5;
  const SceneFile loaded = load("poses.gltf", changes.options);
  ASSERT_TRUE(loaded.ok) << errors();
  save_and_load("poses.gltf", loaded);
  expect_same_camera(loaded);
  expect_same_lights();
  const auto saved = nlohmann::json::parse(std::ifstream(folder_ / "saved.json"));
  EXPECT_EQ(saved["models"][0]["time"], 1.5);
  EXPECT_EQ(saved["ocio"], "grade.ocio");
  EXPECT_EQ(file_again.color_config, changes.ocio);
  EXPECT_EQ(saved["camera"], (nlohmann::json{{"use", "other"}}));
}

TEST_F(SavedDescription, RefusesWhatWouldLoseSomething) {
  const SceneFile loaded = describe(R"({"gltf": [{"file": "lit.gltf"}]})");
  ASSERT_TRUE(loaded.ok) << errors();
  changes.scene = &scene, changes.loaded = &loaded, changes.scene_file = folder_ / "scene.json";
  diagnostics.clear();
  const hd::DiagnosticSink sink = [this](const hd::Diagnostic& d) { diagnostics.push_back(d); };
  EXPECT_FALSE(WriteDescription(changes, folder_ / "scene.json", sink));
  EXPECT_NE(errors().find("choose another name"), std::string::npos) << errors();
  EXPECT_FALSE(WriteDescription(changes, folder_ / "picture.png", sink));
  EXPECT_NE(errors().find(".json"), std::string::npos) << errors();
  EXPECT_FALSE(WriteDescription(changes, folder_ / "no folder" / "a.json", sink));
  EXPECT_FALSE(fs::exists(folder_ / "no folder"));
  fs::remove(folder_ / "scene.json");
  EXPECT_FALSE(WriteDescription(changes, folder_ / "b.json", sink));
  EXPECT_NE(errors().find("is gone"), std::string::npos) << errors();
  EXPECT_FALSE(fs::exists(folder_ / "b.json"));
}

}  // namespace
}  // namespace alabaster::view
