// Archives as scenes and as models of a description.
#include <gtest/gtest.h>

#include "delegate/archive/archive.h"
#include "delegate/description/render_description.h"
#include "delegate/support/lookup.h"
#include "testenv/support/gltf_testing.h"

namespace alabaster::hd::description {
namespace {

using gltf::testing::TemporaryFolder;

class LoadArchive : public ::testing::Test {
 protected:
  LoadArchive() {
    host::RetainedSceneDelegate made;
    host::MeshDescription mesh;
    mesh.topology.scheme = "none";
    mesh.topology.faceVertexCounts = {3};
    mesh.topology.faceVertexIndices = {0, 1, 2};
    mesh.primvars["points"].value = Array<Vec3f>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    made.SetMesh("/body", mesh);
    mesh.instancer = "/many";
    made.SetMesh("/leaf", mesh);
    host::InstancerDescription many;
    many.primvars["hydra:instanceTranslations"] = Array<Vec3f>{{0, 0, 0}, {1, 0, 0}};
    many.indices["/leaf"] = {0, 1};
    made.SetInstancer("/many", many);
    host::CameraDescription camera;
    camera.transform[3][2] = 5;
    made.SetCamera("/first", {});
    made.SetCamera("/second", camera);
    RenderSettingsDescription settings;
    settings.width = 32, settings.height = 16, settings.camera = "/second";
    settings.settings["samples"] = int64_t(7);
    settings.products.resize(1);
    settings.products[0].file = "own.exr";
    made.SetRenderSettings("/main", settings);
    settings.width = 64, settings.products[0].file = "wide.exr";
    made.SetRenderSettings("/wide", settings);
    settings.settings["samples"] = int64_t(3), settings.products.clear();
    made.SetRenderSettings("/quick", settings);
    EXPECT_EQ(archive::WriteArchive(folder_.path() + "/a.alab", made.GetPrims(), {.settings = "/main"}), "");
  }
  SceneFile load(const std::string& document, const LoadOptions& options = {}) {
    const std::string file = document.empty() ? folder_.path() + "/a.alab" : folder_.write("scene.json", document);
    return LoadScene(
        file, &scene_, [this](const Diagnostic& d) { said_ += d.text + "\n"; }, options);
  }

  void clear() {
    for (const Path& path : support::keys_of(scene_.GetMeshes())) scene_.Remove(path);
  }

  TemporaryFolder folder_;
  host::RetainedSceneDelegate scene_;
  std::string said_;
};

// Materials that nothing addresses stay as they were authored.
TEST_F(LoadArchive, LooksOfOtherKindsAreChangedAsTheDisneyMaterialThatTheyAreDrawnAs) {
  const auto look = [](const char* type, std::map<Token, Value> parameters) {
    MaterialNetwork network;
    network.nodes["/look/s"] = {type, std::move(parameters), {}};
    network.terminals["surface"] = {"/look/s", "out"};
    return network;
  };
  host::RetainedSceneDelegate made;
  const MaterialNetwork other = look("UsdPreviewSurface", {});
  made.SetMaterial("/looks/skin", look("ND_open_pbr_surface_surfaceshader", {{"base_color", Vec3f(0.5f, 0.25f, 0)}}));
  made.SetMaterial("/looks/preview", look("UsdPreviewSurface", {{"diffuseColor", Vec3f(0.5f)}}));
  made.SetMaterial("/looks/other", other);
  ASSERT_EQ(archive::WriteArchive(folder_.path() + "/a.alab", made.GetPrims()), "");
  LoadOptions options;
  options.overrides = {"materials/skin.roughness=0.625", "materials/preview.metallic=1"};
  ASSERT_TRUE(load("", options).ok) << said_;
  const auto surface = [&](const char* path) { return scene_.GetMaterials().at(path).nodes.at("/look/s"); };
  EXPECT_EQ(surface("/looks/skin").nodeTypeId, Token("AlabasterDisney"));
  EXPECT_EQ(surface("/looks/skin").parameters.at("baseColor"), Value(Vec3f(0.5f, 0.25f, 0)));
  EXPECT_EQ(surface("/looks/skin").parameters.at("roughness").number_or(0), 0.625);
  EXPECT_EQ(surface("/looks/preview").parameters.at("metallic").number_or(0), 1);
  EXPECT_EQ(scene_.GetMaterials().at("/looks/other"), other);
}

// promise: pipeline.archive.camera, pipeline.archive.lights
TEST_F(LoadArchive, KeepsItsSettingsCamerasAndDarkness) {
  LoadOptions options;
  options.overrides = {"samples=9"};
  const SceneFile file = load("", options);
  ASSERT_TRUE(file.ok) << said_;
  EXPECT_EQ(file.settings, Path("/main"));
  const auto& all = scene_.GetAllRenderSettings();
  EXPECT_EQ(all.at("/main").camera, Path("/second"));
  EXPECT_EQ(all.at("/main").settings.at("samples").number_or(0), 9);
  ASSERT_EQ(all.at("/main").products.size(), 1u);
  EXPECT_EQ(all.at("/main").products[0].file, folder_.path() + "/own.exr");
  // Settings that differ by their size are planned from the first, and take the override; others stay.
  ASSERT_EQ(file.further_settings.size(), 1u);
  EXPECT_EQ(all.at(file.further_settings[0]).width, 64);
  EXPECT_EQ(all.at(file.further_settings[0]).settings.at("samples").number_or(0), 9);
  EXPECT_EQ(all.at("/quick").settings.at("samples").number_or(0), 3);
  EXPECT_TRUE(scene_.GetLights().empty());
  ASSERT_EQ(file.notes.size(), 1u);
  EXPECT_TRUE(file.notes[0].starts_with("no light")) << file.notes[0];
}

// promise: pipeline.archive.copies
TEST_F(LoadArchive, IsAModelWithARootAndAPlace) {
  const SceneFile file =
      load(R"({"models": [{"file": "a.alab"}, {"file": "a.alab", "transform": {"translate": [0, 2, 0]}}],
    "settings": {"samples": 5, "studio": "off"}, "products": [{"file": "other.exr"}]})");
  ASSERT_TRUE(file.ok) << said_;
  EXPECT_EQ(scene_.GetMeshes().at("/body").transform[3][1], 0);
  EXPECT_EQ(scene_.GetMeshes().at("/copy/body").transform[3][1], 2);
  EXPECT_EQ(scene_.GetMeshes().at("/copy/leaf").instancer, Path("/copy/many"));
  EXPECT_EQ(scene_.GetInstancers().at("/copy/many").transform[3][1], 2);
  EXPECT_EQ(scene_.GetMeshes().at("/copy/leaf").transform[3][1], 0) << "its instancer moves it";
  const RenderSettingsDescription& settings = scene_.GetAllRenderSettings().at(file.settings);
  EXPECT_EQ(settings.settings.at("samples").number_or(0), 5);
  EXPECT_EQ(settings.width, 32);
  ASSERT_EQ(settings.products.size(), 1u);
  EXPECT_TRUE(settings.products[0].file.ends_with("other.exr"));
}

// An archive of a description has the description's names, and a third model finds its place beside both.
// promise: pipeline.archive.copies
TEST_F(LoadArchive, ModelsOfEqualPathsAreAllThere) {
  host::RetainedSceneDelegate made;
  host::MeshDescription mesh;
  mesh.primvars["points"].value = Array<Vec3f>{{0, 0, 0}};
  for (const char* path : {"/gltf/one/nodes/0_a/0", "/copy/body", "/copy2/gltf/one/nodes/0_a/0"})
    made.SetMesh(path, mesh);
  ASSERT_EQ(archive::WriteArchive(folder_.path() + "/b.alab", made.GetPrims()), "");
  folder_.write("one.gltf",
                R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0,"name":"a"}],
    "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
    "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}],
    "bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36,"uri":
    "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})");
  const SceneFile file =
      load(R"({"models": [{"file": "b.alab"}, {"file": "one.gltf"}, {"file": "b.alab"}, {"file": "a.alab"},
    {"file": "a.ALAB"}, {"file": "one.gltf"}]})");
  EXPECT_FALSE(file.ok) << "there is no a.ALAB";
  const SceneFile good =
      load(R"({"models": [{"file": "b.alab"}, {"file": "one.gltf"}, {"file": "b.alab"}, {"file": "a.alab"},
    {"file": "one.gltf"}]})");
  ASSERT_TRUE(good.ok) << said_;
  EXPECT_EQ(scene_.GetMeshes().size(), 3u + 1 + 3 + 2 + 1);
}

// promise: pipeline.archive.camera
TEST_F(LoadArchive, PrimsOfLoadingReplaceNoOthers) {
  host::RetainedSceneDelegate made;
  host::MeshDescription mesh;
  mesh.primvars["points"].value = Array<Vec3f>{{0, 0, 0}, {1, 1, 1}};
  for (const char* path : {"/camera", "/render", "/lights/key"}) made.SetMesh(path, mesh);
  ASSERT_EQ(archive::WriteArchive(folder_.path() + "/a.alab", made.GetPrims()), "");
  const SceneFile file = load("");
  ASSERT_TRUE(file.ok) << said_;
  EXPECT_EQ(scene_.GetMeshes().size(), 3u);
  EXPECT_EQ(scene_.GetCameras().size(), 1u);
  EXPECT_FALSE(load(R"({"models": [{"file": "a.alab"}], "lights": [{"name": "key", "type": "sphereLight"}]})").ok);
  EXPECT_NE(said_.find("already a prim '/lights/key'"), std::string::npos) << said_;
}

TEST_F(LoadArchive, DoesNotRaiseTheLimitOfMemoryAndNamesAMissingCamera) {
  host::RetainedSceneDelegate made;
  RenderSettingsDescription settings;
  settings.camera = "/gone";
  settings.settings["memoryLimit"] = int64_t(16777216);
  made.SetRenderSettings("/main", settings);
  ASSERT_EQ(archive::WriteArchive(folder_.path() + "/a.alab", made.GetPrims()), "");
  const SceneFile file = load("");
  ASSERT_TRUE(file.ok);
  EXPECT_FALSE(scene_.GetAllRenderSettings().at("/main").settings.contains("memoryLimit"));
  EXPECT_NE(said_.find("cannot raise the limit"), std::string::npos) << said_;
  EXPECT_NE(said_.find("'/gone'"), std::string::npos) << said_;
}

// promise: pipeline.archive.time
TEST_F(LoadArchive, RefusesChoicesThatOnlyGltfHas) {
  EXPECT_FALSE(load(R"({"models": [{"file": "a.alab", "time": 1}]})").ok);
  EXPECT_NE(said_.find("one scene, at one time"), std::string::npos) << said_;
  LoadOptions options;
  options.animation = "0";
  const SceneFile file = load("", options);
  EXPECT_FALSE(file.ok);
  EXPECT_EQ(file.cause, LoadCause::option);
}

TEST_F(LoadArchive, ModelsHaveOneName) {
  EXPECT_TRUE(load(R"({"gltf": [{"file": "a.alab"}]})").ok) << said_;
  EXPECT_FALSE(load(R"({"gltf": [{"file": "a.alab"}], "models": [{"file": "a.alab"}]})").ok);
  EXPECT_NE(said_.find("former name of 'models'"), std::string::npos) << said_;
}

TEST_F(LoadArchive, IsRefusedWhereMemoryDoesNotHoldIt) {
  LoadOptions options;
  options.overrides = {"memoryLimit=1"};
  host::RetainedSceneDelegate large;
  host::MeshDescription mesh;
  mesh.primvars["points"].value = Array<Vec3f>(std::vector<Vec3f>(100000));
  large.SetMesh("/large", mesh);
  ASSERT_EQ(archive::WriteArchive(folder_.path() + "/a.alab", large.GetPrims()), "");
  const SceneFile file = load("", options);
  EXPECT_FALSE(file.ok);
  EXPECT_EQ(file.cause, LoadCause::out_of_memory);
}

// Without an artist's name a prim is named by the last part of its path that is more than a number.
TEST_F(LoadArchive, PrimsAreNamedByTheirPaths) {
  host::RetainedSceneDelegate made;
  made.SetMesh("/World/head/0", {});
  made.SetMesh("/gltf/bust/nodes/3_ear/1", {});
  made.SetMesh("/World/2/body", {});
  const archive::SceneInfo info{.names = {{"/gltf/bust/nodes/3_ear/1", "ear"}}};
  ASSERT_EQ(archive::WriteArchive(folder_.path() + "/a.alab", made.GetPrims(), info), "");
  for (const auto& [name, path] : {std::pair("head", "/World/head/0"),
                                   {"3_ear", "/gltf/bust/nodes/3_ear/1"},
                                   {"3_e*", "/gltf/bust/nodes/3_ear/1"},
                                   {"ear", "/gltf/bust/nodes/3_ear/1"},
                                   {"body", "/World/2/body"}}) {
    ASSERT_TRUE(load(std::string(R"({"models": [{"file": "a.alab"}], "meshes": [{"match": ")") + name +
                     R"(", "visible": false}]})")
                    .ok)
        << said_;
    for (const auto& [mesh, one] : scene_.GetMeshes()) EXPECT_EQ(one.visible, mesh != Path(path)) << name;
  }
}

}  // namespace
}  // namespace alabaster::hd::description
