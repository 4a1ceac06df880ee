// A length may be typed with its unit, wherever a description or an override takes one.
#include "delegate/archive/archive.h"
#include "testenv/unit/delegate/description/scene_fixture.h"

namespace alabaster::hd::description {
namespace {

class Lengths : public SceneFiles {
 protected:
  Vec3f distance() const {
    for (const auto& [path, network] : scene.GetMaterials())
      for (const auto& [node_path, node] : network.nodes)
        if (const auto found = node.parameters.find("scatterDistance"); found != node.parameters.end())
          return found->second.get_or(Vec3f(-1));
    return Vec3f(-1);
  }
  const host::CameraDescription& camera(const SceneFile& file) const {
    return scene.GetCameras().at(scene.GetAllRenderSettings().at(file.settings).camera);
  }
};

const char* const kPatch = R"({"models": [{"file": "patch.gltf"}]})";

// promise: pipeline.units
TEST_F(Lengths, AValueWithAUnitIsThatOfTheNumberInMetres) {
  const std::string key = "materials/skin.scatterDistance=";
  for (const char* value : {"[3.7,1.4,.7]mm", "[3.7, 1.4, 0.7] mm", "[3.7mm,1.4mm,.7mm]", R"({"mm": [3.7, 1.4, 0.7]})",
                            "[3700,1400,700]um", R"(["3.7mm", "0.14cm", 0.0007])", "[0.0037m,1.4mm,.7mm]"}) {
    EXPECT_TRUE(describe(kPatch, with_overrides({key + value})).ok) << value << errors();
    const Vec3f found = distance();
    EXPECT_EQ(found, Vec3f(0.0037f, 0.0014f, 0.0007f)) << value;
  }
}

TEST_F(Lengths, PlacementsLensesAndImagesTakeUnitsToo) {
  write_image("depth.png");
  const SceneFile file =
      describe(R"({"models": [{"file": "patch.gltf", "transform": {"translate": {"cm": [1, 2, 300]}}}],
    "materials": [{"match": "skin", "set": {"scatterDistance": {"file": "depth.png", "scale": {"mm": [4, 2, 1]}},
                                            "attenuationDistance": "2in"}}],
    "lights": [{"name": "key", "type": "sphereLight", "radius": "1ft", "position": ["1m", 2, "30mm"]}],
    "camera": {"lookAt": {"eye": {"cm": [0, 0, 700]}, "target": [0, 0, 0]}, "focalLength": "8cm", "horizontalAperture": 36,
               "focusDistance": "250cm", "clippingRange": {"cm": [10, 20]}}})");
  ASSERT_TRUE(file.ok) << errors();
  EXPECT_EQ(scene.GetMeshes().begin()->second.transform.translation(), Vec3d(0.01, 0.02, 3));
  EXPECT_EQ(distance(), Vec3f(0.004f, 0.002f, 0.001f));
  const auto& light = scene.GetLights().begin()->second;
  EXPECT_EQ(light.parameters.at("radius"), Value(0.3048f));
  EXPECT_EQ(light.transform.translation(), Vec3d(1, 2, 0.03));
  EXPECT_EQ(camera(file).transform.translation(), Vec3d(0, 0, 7));
  EXPECT_FLOAT_EQ(camera(file).parameters.at("focalLength").get_or(0.0f), 0.08f);
  EXPECT_FLOAT_EQ(camera(file).parameters.at("horizontalAperture").get_or(0.0f), 0.036f);
  EXPECT_EQ(camera(file).parameters.at("focusDistance"), Value(2.5f));
  EXPECT_EQ(camera(file).parameters.at("clippingRange"), Value(Vec2f(0.1f, 0.2f)));
}

// promise: pipeline.units
TEST_F(Lengths, AStageHasItsOwnUnit) {
  ASSERT_TRUE(load("patch.gltf").ok) << errors();
  host::Prims prims = scene.GetPrims();
  std::erase_if(prims, [](const auto& prim) {
    return host::KindOf(prim.second) == "camera" || host::KindOf(prim.second) == "renderSettings";
  });
  archive::SceneInfo info;
  info.metersPerUnit = 0.01;
  ASSERT_EQ(archive::WriteArchive(folder_ / "centimetres.alab", prims, info), "");
  const SceneFile file =
      describe(R"({"models": [{"file": "centimetres.alab", "transform": {"translate": ["30mm", 0, 7]}}],
    "materials": [{"match": "*skin", "set": {"scatterDistance": {"mm": [3, 2, 1]}, "attenuationDistance": 2}}],
    "camera": {"transform": {"translate": ["1m", 0, 7]}, "focalLength": 80, "fStop": 2, "focusDistance": "1m"}})");
  ASSERT_TRUE(file.ok) << errors();
  EXPECT_EQ(distance(), Vec3f(0.3f, 0.2f, 0.1f));
  EXPECT_EQ(scene.GetMeshes().begin()->second.transform.translation(), Vec3d(3, 0, 7));
  EXPECT_EQ(camera(file).transform.translation(), Vec3d(100, 0, 7));
  EXPECT_EQ(camera(file).parameters.at("focusDistance"), Value(100.0f));
  EXPECT_FLOAT_EQ(camera(file).parameters.at("focalLength").get_or(0.0f), 8) << "80 mm";
  EXPECT_FLOAT_EQ(camera(file).parameters.at("horizontalAperture").get_or(0.0f), 3.6f) << "36 mm by default";

  info.metersPerUnit = 1e-300;
  ASSERT_EQ(archive::WriteArchive(folder_ / "tiny.alab", prims, info), "");
  for (const char* length : {R"({"m": 1e10})", R"("1e10m")", R"(["1m", "2m", "3m"])"}) {
    EXPECT_FALSE(
        describe(R"({"models": [{"file": "tiny.alab"}], "materials": [{"match": "*skin", "set": {"scatterDistance": )" +
                 std::string(length) + "}}]}")
            .ok);
    EXPECT_NE(errors().find("A length is too large in the scene's unit"), std::string::npos) << errors();
  }
}

TEST_F(Lengths, ModelsBehindOneThatFailsAreStillLookedAt) {
  EXPECT_FALSE(
      describe(
          R"({"models": [{"file": "missing.gltf"}, {"file": "patch.gltf", "transform": {"translate": "[1, 2, 3]mm"}}]})")
          .ok);
  EXPECT_EQ(errors().find("json.exception"), std::string::npos) << errors();
}

TEST_F(Lengths, WhatIsNoLengthIsRefusedWithTheUnits) {
  const char* const units = "A length may have a unit, um, mm, cm, m, in or ft: 3.7mm.";
  for (const char* one :
       {"camera.focusDistance=3parsec", "camera.focusDistance=mm", "camera.focusDistance=[]mm",
        "camera.focusDistance=1e400mm", "camera.focusDistance=nanmm", "camera.focalLength=3 4mm",
        "materials/skin.scatterDistance=[1,2,3k]mm", R"(materials/skin.scatterDistance=["1mm","2x",3])",
        R"(camera.lookAt={"eye": ["x", 0, 1], "target": [0, 0, 0]})"}) {
    EXPECT_EQ(describe(kPatch, with_overrides({one})).cause, LoadCause::option) << one;
    EXPECT_NE(errors().find(units), std::string::npos) << one << ": " << errors();
  }
  const std::pair<const char*, const char*> refused[] = {
      {"camera.focusDistance=-3mm", "at least 0"},
      {R"(camera.focusDistance={"mm": "3"})", "must be a number"},
      {R"(materials/skin.scatterDistance={"mm": [1, 2]})", "three numbers"},
      {R"(materials/skin.scatterDistance={"mm": 1, "cm": 2})", "Unknown key 'cm'"},
      {"materials/skin.roughness=3mm", "'roughness' must be a number from 0 to 1, and is \"3mm\".\n"},
      {"camera.fStop=2mm", "'fStop' must be a number"}};
  for (const auto& [one, said] : refused) {
    EXPECT_EQ(describe(kPatch, with_overrides({one})).cause, LoadCause::option) << one;
    EXPECT_NE(errors().find(said), std::string::npos) << one << ": " << errors();
  }
}

}  // namespace
}  // namespace alabaster::hd::description
