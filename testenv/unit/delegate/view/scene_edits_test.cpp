// Edits of materials and lights from a panel.
#include "delegate/view/scene_edits.h"

#include <gtest/gtest.h>

#include "testenv/unit/delegate/view/row_of.h"

namespace alabaster::view {
namespace {

using hd::Path;
using hd::Value;
using hd::Vec3f;

const Path kSkin = "/materials/skin", kPreview = "/materials/preview", kKey = "/lights/key";

// A material with an image as its colour, one that is not ours, and a light.
class SceneEditsTest : public ::testing::Test {
 protected:
  SceneEditsTest() {
    hd::MaterialNetwork skin;
    hd::MaterialNode& surface = skin.nodes["/materials/skin/surface"];
    surface.nodeTypeId = "AlabasterDisney";
    surface.parameters["roughness"] = 0.25f;
    surface.parameters["baseColor"] = Vec3f(0.5f, 0.5f, 0.5f);
    surface.inputConnections["baseColor"] = {{"/materials/skin/image", "rgb"}};
    hd::MaterialNode& image = skin.nodes["/materials/skin/image"];
    image.nodeTypeId = "AlabasterTexture";
    image.parameters["file"] = hd::AssetPath{"skin.png", "/somewhere/skin.png", nullptr};
    skin.terminals["surface"] = {"/materials/skin/surface", "surface"};
    scene.SetMaterial(kSkin, skin);

    hd::MaterialNetwork preview;
    preview.nodes["/materials/preview/surface"].nodeTypeId = "UsdPreviewSurface";
    preview.terminals["surface"] = {"/materials/preview/surface", "surface"};
    scene.SetMaterial(kPreview, preview);

    hd::host::LightDescription key;
    key.type = "rectLight";
    key.parameters["intensity"] = 7.0f;
    scene.SetLight(kKey, key);
    loaded = scene.GetMaterials().at(kSkin);
  }
  const hd::MaterialNode& surface() { return scene.GetMaterials().at(kSkin).nodes.at("/materials/skin/surface"); }

  hd::host::RetainedSceneDelegate scene;
  hd::MaterialNetwork loaded;
};

TEST_F(SceneEditsTest, OffersOurMaterialsAndAllLights) {
  const SceneEdits edits(&scene);
  EXPECT_EQ(edits.materials(), std::vector<Path>{kSkin});
  EXPECT_EQ(edits.lights(), std::vector<Path>{kKey});
  EXPECT_EQ(edits.light_type(kKey), "rectLight");
  EXPECT_EQ(edits.value(kSkin, row_of("disney_material", "roughness")), Value(0.25f));
  EXPECT_EQ(edits.value(kSkin, row_of("disney_material", "ior")).number_or(0), 1.5) << "the schema's default";
  EXPECT_EQ(edits.value(kKey, row_of("lights", "intensity")), Value(7.0f));
}

TEST_F(SceneEditsTest, AnEditReachesTheSceneAndTheRecord) {
  SceneEdits edits(&scene);
  EXPECT_EQ(edits.set(kSkin, row_of("disney_material", "roughness"), 0.5), "");
  EXPECT_EQ(edits.set(kSkin, row_of("disney_material", "thin"), true), "");
  EXPECT_EQ(edits.set(kKey, row_of("lights", "intensity"), 3.0), "");
  EXPECT_EQ(surface().parameters.at("roughness"), Value(0.5f));
  EXPECT_EQ(surface().parameters.at("thin"), Value(true));
  EXPECT_EQ(scene.GetLights().at(kKey).parameters.at("intensity"), Value(3.0f));
  EXPECT_TRUE(edits.is_changed(kSkin, "roughness"));
  EXPECT_FALSE(edits.is_changed(kSkin, "ior"));
  EXPECT_EQ(edits.record().materials.at(kSkin).size(), 2u);
  EXPECT_EQ(edits.record().lights.at(kKey).at("intensity"), Value(3.0f));
}

TEST_F(SceneEditsTest, ValuesStayWithinTheirLimits) {
  SceneEdits edits(&scene);
  EXPECT_EQ(edits.set(kSkin, row_of("disney_material", "ior"), 100.0), "");
  EXPECT_EQ(edits.set(kSkin, row_of("disney_material", "baseColor"), Vec3f(-1, 0.5f, 2)), "");
  EXPECT_EQ(surface().parameters.at("ior"), Value(4.0f));
  EXPECT_EQ(surface().parameters.at("baseColor"), Value(Vec3f(0, 0.5f, 1)));
}

TEST_F(SceneEditsTest, AConstantTakesAnImagesPlaceAndAResetBringsItBack) {
  SceneEdits edits(&scene);
  EXPECT_EQ(edits.texture(kSkin, "baseColor"), "skin.png");
  EXPECT_EQ(edits.texture(kSkin, "roughness"), "");
  EXPECT_EQ(edits.set(kSkin, row_of("disney_material", "baseColor"), Vec3f(1, 0, 0)), "");
  EXPECT_EQ(edits.texture(kSkin, "baseColor"), "");
  EXPECT_FALSE(surface().inputConnections.contains("baseColor"));
  EXPECT_EQ(edits.set(kSkin, row_of("disney_material", "ior"), 2.0), "");
  EXPECT_EQ(edits.reset(kSkin, "baseColor"), "");
  EXPECT_EQ(edits.texture(kSkin, "baseColor"), "skin.png");
  EXPECT_TRUE(edits.is_changed(kSkin, "ior")) << "the other edit stays";
  EXPECT_EQ(edits.reset(kSkin, "ior"), "");
  EXPECT_EQ(scene.GetMaterials().at(kSkin), loaded);
  EXPECT_TRUE(edits.record().materials.empty());
}

TEST_F(SceneEditsTest, AFaultOfTheSceneIsReturnedAndNothingIsRecorded) {
  SceneEdits edits(&scene);
  EXPECT_EQ(edits.set(kSkin, row_of("disney_material", "ior"), 2.0), "");
  scene.Remove(kSkin);
  EXPECT_NE(edits.set(kSkin, row_of("disney_material", "roughness"), 0.5).find("no prim"), std::string::npos);
  EXPECT_NE(edits.reset(kSkin, "ior").find("no prim"), std::string::npos);
  EXPECT_FALSE(edits.is_changed(kSkin, "roughness"));
  EXPECT_TRUE(edits.is_changed(kSkin, "ior")) << "it was not taken back";
}

TEST_F(SceneEditsTest, LightsAreAddedPlacedAndRemoved) {
  SceneEdits edits(&scene);
  const hd::host::LightDescription key = scene.GetLights().at(kKey);
  hd::Matrix4d there;
  there.setTranslation(hd::Vec3d(1, 2, 3));
  EXPECT_EQ(edits.place(kKey, there), "");
  EXPECT_EQ(edits.transform(kKey), there);
  EXPECT_TRUE(edits.is_changed(kKey, "transform"));
  hd::host::LightDescription rect;
  rect.type = "rectLight";
  const Path first = edits.add_light(rect), second = edits.add_light(rect);
  EXPECT_EQ(first, Path("/lights/rect"));
  EXPECT_EQ(edits.lights(), (std::vector<Path>{kKey, first, second})) << "each has a name of its own";
  EXPECT_EQ(edits.set(second, row_of("lights", "intensity"), 3.0), "");
  EXPECT_EQ(scene.GetLights().at(second).parameters.at("intensity"), Value(3.0f));
  edits.remove_light(second);
  edits.remove_light(kKey);
  EXPECT_EQ(edits.lights(), (std::vector<Path>{kKey, first})) << "the scene's own stays";
  EXPECT_FALSE(scene.GetLights().contains(second));
  EXPECT_FALSE(edits.is_changed(second, "intensity"));
  EXPECT_EQ(edits.reset(kKey, "transform"), "");
  EXPECT_EQ(scene.GetLights().at(kKey), key);
}

// A light that moves stands still where it is placed, and moves again after a reset.
TEST_F(SceneEditsTest, AResetOfAPlaceBringsMotionBack) {
  hd::host::LightDescription moving = scene.GetLights().at(kKey);
  moving.transformSamples = {{0, 1}, {hd::Matrix4d(), hd::Matrix4d().setTranslation(hd::Vec3d(1, 0, 0))}};
  scene.SetLight(kKey, moving);
  SceneEdits edits(&scene);
  EXPECT_EQ(edits.place(kKey, hd::Matrix4d().setTranslation(hd::Vec3d(0, 5, 0))), "");
  EXPECT_TRUE(scene.GetLights().at(kKey).transformSamples.values.empty());
  EXPECT_EQ(edits.reset(kKey, "transform"), "");
  EXPECT_EQ(scene.GetLights().at(kKey), moving);
}

// The scene meanwhile has lost its key, has a light where one was added, and another type of a light.
TEST_F(SceneEditsTest, ARecordIsRestoredAsFarAsTheSceneHasPlace) {
  hd::host::LightDescription rect, sphere;
  rect.type = "rectLight", sphere.type = "sphereLight";
  scene.SetLight("/lights/fill", rect);
  SceneEdits edits(&scene);
  EXPECT_EQ(edits.set(kSkin, row_of("disney_material", "ior"), 2.0), "");
  EXPECT_EQ(edits.set(kKey, row_of("lights", "intensity"), 3.0), "");
  EXPECT_EQ(edits.set("/lights/fill", row_of("lights", "width"), 3.0), "");
  EXPECT_EQ(edits.set("/lights/fill", row_of("lights", "intensity"), 4.0), "");
  const Path first = edits.add_light(rect), second = edits.add_light(rect);
  EXPECT_EQ(edits.set(first, row_of("lights", "intensity"), 5.0), "");
  const EditRecord record = edits.record();

  EXPECT_TRUE(edits.restore({}).empty());
  EXPECT_EQ(scene.GetMaterials().at(kSkin), loaded);
  EXPECT_EQ(edits.lights().size(), 2u);
  EXPECT_TRUE(edits.restore(record).empty());
  EXPECT_EQ(edits.record().lights, record.lights);
  EXPECT_EQ(edits.record().added, record.added);
  EXPECT_EQ(scene.GetLights().at(first).parameters.at("intensity"), Value(5.0f));

  hd::host::RetainedSceneDelegate other;
  other.SetMaterial(kSkin, loaded);
  other.SetLight("/lights/fill", sphere);
  other.SetLight(first, sphere);
  SceneEdits later(&other);
  const auto faults = later.restore(record);
  ASSERT_EQ(faults.size(), 3u);
  EXPECT_EQ(faults[0].first, first) << "the scene's own is left alone";
  EXPECT_EQ(faults[1].first, Path("/lights/fill"));
  EXPECT_NE(faults[1].second.find("no 'width'"), std::string::npos) << faults[1].second;
  EXPECT_EQ(faults[2].first, kKey);
  EXPECT_NE(faults[2].second.find("waits"), std::string::npos) << faults[2].second;
  EXPECT_EQ(other.GetLights().at(first), sphere);
  EXPECT_EQ(other.GetLights().at("/lights/fill").parameters.at("intensity"), Value(4.0f));
  EXPECT_TRUE(later.is_added(second));
  EXPECT_TRUE(later.is_changed(kSkin, "ior"));
}

TEST_F(SceneEditsTest, AChangeWaitsForItsPrim) {
  SceneEdits edits(&scene);
  EXPECT_EQ(edits.set(kSkin, row_of("disney_material", "ior"), 2.0), "");
  EXPECT_EQ(edits.set(kKey, row_of("lights", "intensity"), 3.0), "");
  hd::host::RetainedSceneDelegate empty;
  SceneEdits without(&empty);
  EXPECT_EQ(without.restore(edits.record()).size(), 2u);
  EXPECT_TRUE(without.restore(EditRecord(without.record())).empty()) << "that they wait is said once";
  EXPECT_TRUE(without.made().materials.empty());
  EXPECT_TRUE(without.made().lights.empty());

  hd::host::RetainedSceneDelegate again;
  again.SetMaterial(kSkin, loaded);
  again.SetLight(kKey, scene.GetLights().at(kKey));
  SceneEdits later(&again);
  EXPECT_TRUE(later.restore(without.record()).empty());
  EXPECT_EQ(again.GetMaterials().at(kSkin), scene.GetMaterials().at(kSkin));
  EXPECT_EQ(again.GetLights(), scene.GetLights());
  EXPECT_EQ(later.made().materials, edits.record().materials);
  EXPECT_EQ(later.made().lights, edits.record().lights);
  EXPECT_TRUE(without.restore({}).empty());
  EXPECT_TRUE(without.record().materials.empty()) << "it was taken back";
}

TEST_F(SceneEditsTest, PrimsThatAreNotThereAreLeftAlone) {
  SceneEdits edits(&scene);
  const hd::host::Prims prims = scene.GetPrims();
  EXPECT_NE(edits.set("/nowhere", row_of("disney_material", "ior"), 2.0), "");
  EXPECT_NE(edits.set(kPreview, row_of("disney_material", "ior"), 2.0), "");
  EXPECT_NE(edits.reset("/nowhere", "ior"), "");
  EXPECT_TRUE(scene.GetPrims() == prims);
  EXPECT_TRUE(edits.record().materials.empty());
}

}  // namespace
}  // namespace alabaster::view
