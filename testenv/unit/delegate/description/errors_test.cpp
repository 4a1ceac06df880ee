// Every fault of a description is reported with its place and a remedy.
#include <OpenImageIO/imageio.h>

#include <ctime>

#include "testenv/unit/delegate/description/scene_fixture.h"

namespace alabaster::hd::description {
namespace {

#define EXPECT_SAYS(text) EXPECT_NE(errors().find(text), std::string::npos) << "said: " << errors()

class DescriptionErrors : public SceneFiles {};

TEST_F(DescriptionErrors, UnknownKeyNamesNearestKeyPointerAndLine) {
  EXPECT_FALSE(describe("{\n  \"gltf\": [{\"file\": \"patch.gltf\"}],\n  \"materials\": [\n    {\"match\": \"skin\",\n"
                        "     \"set\": {\"roughnes\": 0.2}}\n  ]\n}")
                   .ok);
  EXPECT_SAYS("scene.json:5 /materials/0/set/roughnes: Unknown key 'roughnes'. Did you mean 'roughness'?");
}

TEST_F(DescriptionErrors, EveryUnknownKeyIsReported) {
  EXPECT_FALSE(describe(R"({"setings": {}, "camera": {"fstop": 2}})").ok);
  EXPECT_SAYS("Did you mean 'settings'?");
  EXPECT_SAYS("Did you mean 'fStop'?");
}

// A key that stands a level too high or too low, or in the wrong part.
TEST_F(DescriptionErrors, AKeyOfAnotherPartNamesThePart) {
  const std::string model = R"({"gltf": [{"file": "patch.gltf"}], )";
  const std::pair<const char*, const char*> cases[] = {
      {R"("materials": [{"match": "skin", "baseColor": [1, 0, 0]}]})", "'baseColor'. 'set' has a key of this name."},
      {R"("materials": [{"match": "skin", "set": {"surface.baseColor": [1, 0, 0]}}]})", "Did you mean 'baseColor'?"},
      {R"("materials": [{"match": "skin", "set": {"inputs:rougness": 1}}]})", "Did you mean 'roughness'?"},
      {R"("settings": {"fStop": 2}})", "'fStop'. 'camera' has a key of this name."},
      {R"("fStop": 2})", "'fStop'. 'camera' has a key of this name."},
      {R"("baseColor": 2})", "'baseColor'. 'materials/set' has a key of this name."},
      {R"("lights": [{"name": "a", "type": "domeLight", "texture": "x"}]})", "Did you mean 'texture:file'?"}};
  for (const auto& [text, said] : cases) {
    EXPECT_FALSE(describe(model + text).ok) << text;
    EXPECT_SAYS(said);
  }
}

TEST_F(DescriptionErrors, AFileOfAnotherKindIsNoModel) {
  write("model.obj", "v 0 0 0");
  EXPECT_FALSE(describe(R"({"models": [{"file": "model.obj"}]})").ok);
  EXPECT_SAYS("/models/0/file: '" + (folder_ / "model.obj").string() +
              "' is not a model: name a file that ends in .gl");
}

// Several prims may have one name, and a path selects one.
TEST_F(DescriptionErrors, ANearNameOfSeveralPrimsComesWithTheirPaths) {
  EXPECT_FALSE(describe(R"({"gltf": [{"file": "patch.gltf"}, {"file": "patch.gltf"}],
    "materials": [{"match": "skim", "set": {"roughness": 1}}]})")
                   .ok);
  EXPECT_SAYS("Did you mean 'skin'? It names 2, a path one of them: '/copy2/gltf/patch/materials/0_skin', '/gltf/");
  EXPECT_FALSE(describe(R"({"gltf": [{"file": "patch.gltf"}],
    "materials": [{"match": "skin.surface", "set": {"roughness": 1}}]})")
                   .ok);
  EXPECT_SAYS("No material matches 'skin.surface'. Did you mean 'skin'?");
}

TEST_F(DescriptionErrors, AFaultOfAValueNamesTheLine) {
  EXPECT_FALSE(describe("{\"settings\":\n{\"samples\": 0}}").ok);
  EXPECT_SAYS("scene.json:2 /settings/samples: 'samples' must be a whole number from 1 to 1048576, and is 0.");
  EXPECT_FALSE(describe(R"({"camera": {"lookAt": {"eye": [0, 0, 1]}}})").ok);
  EXPECT_SAYS("/camera/lookAt: 'target' is missing.");
}

TEST_F(DescriptionErrors, AnAngleIsForTheParameterThatIsOne) {
  write_image("map.hdr");
  const auto set = [](const std::string& parameter) {
    return R"({"gltf": [{"file": "patch.gltf"}], "materials": [{"match": "skin", "set": {")" + parameter +
           R"(": {"file": "map.hdr", "channel": "direction"}}}]})";
  };
  EXPECT_TRUE(describe(set("anisotropicRotation")).ok) << errors();
  EXPECT_FALSE(describe(set("opacity")).ok);
  EXPECT_SAYS("/materials/0/set/opacity/channel: Only anisotropicRotation reads an angle; name r, g, b or a.");
}

TEST_F(DescriptionErrors, MotionAndShutter) {
  const auto model = [](const std::string& rest) { return R"({"gltf": [{"file": "patch.gltf", )" + rest + "}]}"; };
  const std::string still = R"({"time": 0, "transform": {}})",
                    flat = R"({"time": 1, "transform": {"scale": [1, 0, 1]}})";
  EXPECT_FALSE(describe(model("\"motion\": [" + still + "]")).ok);
  EXPECT_SAYS("/gltf/0/motion");
  EXPECT_FALSE(describe(model("\"motion\": [" + still + ", " + still + "]")).ok);
  EXPECT_SAYS("/gltf/0/motion/1/time: Times must increase from one sample to the next.");
  EXPECT_FALSE(describe(model("\"motion\": [" + still + ", " + flat + "]")).ok);
  EXPECT_SAYS("/gltf/0/motion/1/transform: The transform cannot be inverted");
  EXPECT_FALSE(
      describe(model(R"("transform": {}, "motion": [{"time": 0, "transform": {}}, {"time": 1, "transform": {}}])")).ok);
  EXPECT_SAYS("Give either a transform or a motion");
  EXPECT_FALSE(
      describe(R"({"gltf": [{"file": "patch.gltf"}], "camera": {"shutterOpen": 0.5, "shutterClose": 0.25}})").ok);
  EXPECT_SAYS("The shutter closes before it opens");
}

TEST_F(DescriptionErrors, CamerasOfOneNameAreListed) {
  std::string two = patch_gltf(true, false);
  const std::string camera = R"({"name": "front", "camera": 0, "translation": [0, 0, 5]})";
  two.replace(two.find(camera), camera.size(), camera + ", " + camera);
  two.replace(two.find("[0,1]"), 5, "[0,1,2]");
  write("two.gltf", two);
  EXPECT_FALSE(load("two.gltf", with_camera("front")).ok);
  EXPECT_SAYS("'front' names 2 cameras: '/");
  std::vector<Path> paths;
  for (const auto& [path, made] : scene.GetCameras())
    if (path.str().ends_with("front")) paths.push_back(path);
  ASSERT_EQ(paths.size(), 2u);
  for (const Path& path : paths) EXPECT_SAYS("'" + path.str() + "'");
  EXPECT_TRUE(load("two.gltf", with_camera(paths[1].str())).ok) << errors();
}

TEST_F(DescriptionErrors, LayersOfImagesAreNamed) {
  OIIO::ImageSpec spec(2, 2, 3, OIIO::TypeFloat);
  spec.channelnames = {"diffuse.R", "diffuse.G", "diffuse.B"};
  spec.channelnames.push_back("Z"), spec.nchannels = 4;
  const std::vector<float> pixels(16, 0.5f);
  const std::string file = folder_ / "layers.exr";
  const auto out = OIIO::ImageOutput::create(file);
  ASSERT_TRUE(out->open(file, spec) && out->write_image(OIIO::TypeFloat, pixels.data()) && out->close());
  const auto material = [](const std::string& layer) {
    return R"({"gltf": [{"file": "patch.gltf"}],
               "materials": [{"match": "skin", "set": {"baseColor": {"file": "layers.exr")" +
           layer + "}}}]}";
  };
  const auto light = [](const std::string& layer) {
    return R"({"lights": [{"name": "sky", "type": "domeLight", "texture:file": "layers.exr")" + layer + "}]}";
  };
  EXPECT_FALSE(describe(material("")).ok);
  EXPECT_SAYS("it has Z, diffuse; name one of them as the texture's 'layer'");
  EXPECT_FALSE(describe(light("")).ok);
  EXPECT_SAYS("it has Z, diffuse;");
  EXPECT_FALSE(describe(material(R"(, "layer": "gone")")).ok);
  EXPECT_SAYS("it has no layer 'gone'");
  EXPECT_TRUE(describe(material(R"(, "layer": "diffuse")")).ok) << errors();
  EXPECT_TRUE(describe(light(R"(, "texture:layer": "diffuse")")).ok) << errors();
  EXPECT_EQ(scene.GetLights().at("/lights/sky").parameters.at("texture:layer").text_or(""), "diffuse");
}

TEST_F(DescriptionErrors, BrokenJsonNamesTheLine) {
  EXPECT_FALSE(describe("{\n  \"settings\": {\n    \"samples\": 4,,\n  }\n}").ok);
  EXPECT_SAYS("line 3: not valid JSON");
  EXPECT_FALSE(describe("{\"settings\": {},\n \"settings\": {}}").ok);
  EXPECT_SAYS("line 2: the key \"settings\" appears twice");
  EXPECT_FALSE(describe(std::string(100000, '[')).ok);
  EXPECT_SAYS("nested deeper than 64 levels");
  EXPECT_FALSE(describe("").ok);
  EXPECT_SAYS("not valid JSON");
  EXPECT_FALSE(describe("{\"settings\": {\n\"samples\": 1e999}}").ok);
  EXPECT_SAYS("line 2: 1e999 is larger than any number");
  EXPECT_FALSE(describe("{\"camera\": {\"use\": \"\xff\xfe\"}}").ok);
}

// Twice as many faults take twice as long: at 200000 they took minutes, and gigabytes where a key was long.
// promise: security.no_time
TEST_F(DescriptionErrors, ManyFaultsAndLongKeysTakeLittleTime) {
  const std::clock_t start = std::clock();
  std::string lights;
  for (int i = 0; i < 20000; ++i)
    lights += R"({"name": "a", "type": "rectLight", "color": [-1, -1, -1], "position": ["x"]},)";
  lights.back() = ']';
  EXPECT_FALSE(describe("{\"lights\": [" + lights + "}").ok);
  EXPECT_EQ(diagnostics.size(), 101u);
  EXPECT_SAYS("more faults like these");
  std::string ones;
  for (int i = 0; i < 30000; ++i) ones += "1,";
  ones.back() = ']';
  EXPECT_FALSE(describe("{\"" + std::string(200000, 'k') + "\": [" + ones + "}").ok);
  EXPECT_SAYS("Unknown key");
  EXPECT_LT(errors().size(), 1000u);
  EXPECT_LT(std::clock() - start, 30 * CLOCKS_PER_SEC);
}

// A walk over all names for each one took minutes for 64000.
// promise: security.no_time
TEST_F(DescriptionErrors, ManyNamesTakeLittleTime) {
  const std::clock_t start = std::clock();
  constexpr int kCount = 12000;
  std::string lights, links, models;
  for (int i = 0; i < kCount; ++i) {
    const std::string name = "l" + std::to_string(i);
    lights += R"({"name": ")" + name + R"(", "type": "sphereLight", "lightLink": ["patch"]},)";
    links += R"({"match": ")" + name + R"(", "intensity": 2},)";
    models += R"({"file": "patch.gltf"},)";
  }
  links.back() = ']', models.back() = ']';
  EXPECT_TRUE(describe(R"({"models": [{"file": "patch.gltf"}], "lights": [)" + lights + links + "}").ok) << errors();
  EXPECT_EQ(scene.GetLights().at("/lights/l7").parameters.at("intensity").number_or(0), 2);
  EXPECT_EQ(scene.GetMeshes().begin()->second.categories.size(), size_t(kCount));
  EXPECT_TRUE(describe(R"({"models": [)" + models + "}").ok) << errors();
  EXPECT_EQ(scene.GetMeshes().size(), size_t(kCount));
  EXPECT_LT(std::clock() - start, 30 * CLOCKS_PER_SEC);
}

TEST_F(DescriptionErrors, AMaterialOrLightOfTheDescriptionIsFoundByItsName) {
  EXPECT_TRUE(describe(R"({"models": [{"file": "patch.gltf"}],
    "materials": [{"match": "skin", "set": {"roughness": 0.1}}, {"name": "made", "replace": {"roughness": 0.2}},
                  {"match": "made", "set": {"roughness": 0.3}}, {"match": "ski?", "set": {"metallic": 0.4}}],
    "meshes": [{"match": "patch", "material": "made"}]})")
                  .ok)
      << errors();
  const auto& surface = scene.GetMaterials().at("/materials/made").nodes.at("/materials/made/surface");
  EXPECT_EQ(surface.parameters.at("roughness"), Value(0.3f));
  EXPECT_EQ(scene.GetMeshes().begin()->second.material, Path("/materials/made"));
}

TEST_F(DescriptionErrors, NamesThatAreNoPathsHereAreToldAsWhatTheyAre) {
  for (const auto& [file, said] : {std::pair{"http://host/sky.png", "a URI with the scheme 'http:'"},
                                   {"file:///sky.png", "a URI with the scheme 'file:'"},
                                   {"data:image/png;base64,AAAA", "a data URI"},
                                   {R"(C:\\sky.png)", "a drive letter, 'C:'"},
                                   {"d:/sky.png", "a drive letter, 'd:'"},
                                   {R"(\\\\server\\sky.png)", "a share of Windows"},
                                   {R"(maps\\sky.png)", "does not separate folders"},
                                   {"/elsewhere/sky.png", "an absolute path"},
                                   {"../sky.png", "outside the folder"}}) {
    const std::string name = std::string("\"") + file + "\"";
    EXPECT_FALSE(describe(R"({"lights": [{"name": "a", "type": "domeLight", "texture:file": )" + name + "}]}").ok);
    EXPECT_SAYS(said);
    EXPECT_FALSE(describe(R"({"models": [{"file": )" + name + "}]}").ok);
    EXPECT_SAYS(said);
  }
  write_image("take:1.hdr");
  EXPECT_TRUE(describe(R"({"models": [{"file": "patch.gltf"}],
    "lights": [{"name": "a", "type": "domeLight", "texture:file": "take:1.hdr"}]})")
                  .ok)
      << errors();
}

TEST_F(DescriptionErrors, MatchesNothing) {
  EXPECT_FALSE(describe(R"({"gltf": [{"file": "patch.gltf"}],
    "materials": [{"match": "skim", "set": {"roughness": 1}}]})")
                   .ok);
  EXPECT_SAYS("scene.json:2 /materials/0/match: No material matches 'skim'. Did you mean 'skin'?");
  EXPECT_FALSE(describe(R"({"gltf": [{"file": "patch.gltf"}], "meshes": [{"match": "pat"}]})").ok);
  EXPECT_SAYS("No mesh matches 'pat'. Did you mean 'patch'?");
  EXPECT_FALSE(describe(R"({"lights": [{"match": "*", "intensity": 1}]})").ok);
  EXPECT_SAYS("The scene has none.");
  EXPECT_FALSE(load("lit.gltf", with_camera("frnt")).ok);
  EXPECT_SAYS("No camera matches 'frnt'. Did you mean 'front'?");
}

TEST_F(DescriptionErrors, ContradictionsAndImpossibilities) {
  const std::string patch = R"({"gltf": [{"file": "patch.gltf"}], )";
  EXPECT_FALSE(describe(patch + R"("meshes": [{"match": "patch", "creases": [{"points": [0, 4]}]}]})").ok);
  EXPECT_SAYS("/meshes/0/creases/0/points/1: Point 4 does not exist");
  EXPECT_FALSE(describe(R"({"lights": [{"name": "a", "type": "sphereLight", "width": 1}]})").ok);
  EXPECT_SAYS("A sphereLight has no 'width'; that belongs to rectLight.");
  EXPECT_FALSE(describe(R"({"lights": [{"name": "a", "type": "rectLight"}, {"name": "a", "type": "rectLight"}]})").ok);
  EXPECT_SAYS("already a light '/lights/a'");
  EXPECT_FALSE(describe(R"({"camera": {"lookAt": {"eye": [0, 1, 0], "target": [0, 0, 0], "up": [0, 2, 0]}}})").ok);
  EXPECT_SAYS("up lies along the line between them");
  EXPECT_FALSE(describe(R"({"gltf": [{"file": "patch.gltf", "transform": {"scale": [1, 0, 1]}}]})").ok);
  EXPECT_SAYS("cannot be inverted");
  EXPECT_FALSE(describe(R"({"gltf": [{"file": "none.glb"}]})").ok);
  EXPECT_SAYS("none.glb'");
  EXPECT_FALSE(describe(R"({"settings": {"crop": [10, 10, 10, 20]}})").ok);
  EXPECT_SAYS("The crop is empty");
  EXPECT_FALSE(describe(R"({"products": [{"file": "a.png", "colorSpace": "raw", "exposure": 1}]})").ok);
  EXPECT_SAYS("not both");
  EXPECT_FALSE(describe(R"({"camera": {"projection": "orthographic"}})").ok);
  EXPECT_SAYS("add a lookAt or a transform");
}

TEST_F(DescriptionErrors, Files) {
  EXPECT_FALSE(load("absent.json").ok);
  EXPECT_SAYS("no such file");
  write("scene.obj", "v 0 0 0");
  EXPECT_FALSE(load("scene.obj").ok);
  EXPECT_SAYS("use .gltf, .glb, .usd, .usda, .usdc, .usdz, .json (a render description) or .alab");
  EXPECT_FALSE(load(".").ok);
  EXPECT_SAYS("not a regular file");
}

TEST_F(DescriptionErrors, FarNamesAreNotSuggested) {
  EXPECT_FALSE(describe(R"({"wallpaper": 1})").ok);
  EXPECT_SAYS("Unknown key 'wallpaper'.");
  EXPECT_EQ(errors().find("Did you mean"), std::string::npos) << errors();
}

// promise: pipeline.name.set
TEST_F(DescriptionErrors, OverridesAreCheckedLikeFiles) {
  EXPECT_FALSE(load("patch.gltf", with_overrides({"materials/skin.rougness=0.1"})).ok);
  EXPECT_SAYS("materials/skin.rougness=0.1: Unknown key 'rougness'. Did you mean 'roughness'?");
  EXPECT_FALSE(load("patch.gltf", with_overrides({"samples"})).ok);
  EXPECT_SAYS("write key=value");
  EXPECT_FALSE(load("patch.gltf", with_overrides({"material/skin.roughness=1"})).ok);
  EXPECT_SAYS("Did you mean 'materials/skin.roughness'?");
  EXPECT_FALSE(load("patch.gltf", with_overrides({"materials/skin=1"})).ok);
  EXPECT_SAYS("does not name a parameter");
  EXPECT_FALSE(load("patch.gltf", with_dome("absent.hdr,2")).ok);
  EXPECT_SAYS("There is no file 'absent.hdr'");
}

TEST_F(DescriptionErrors, TextsOfACommandLineAreUtf8) {
  const std::string bytes(100, '\x80');
  EXPECT_FALSE(load("patch.gltf", with_overrides({"materials/" + bytes + ".baseColor=1"})).ok);
  EXPECT_SAYS("is not UTF-8");
  EXPECT_FALSE(load("patch.gltf", with_overrides({"materials/skin.baseColor=" + bytes})).ok);
  EXPECT_SAYS("is not UTF-8");
  EXPECT_FALSE(load("patch.gltf", with_dome(bytes + ".hdr")).ok);
  EXPECT_SAYS("is not UTF-8");
}

}  // namespace
}  // namespace alabaster::hd::description
