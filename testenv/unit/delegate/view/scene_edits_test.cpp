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
  EXPECT_EQ(edits.changed_materials().at(kSkin).size(), 2u);
  EXPECT_EQ(edits.changed_lights().at(kKey).at("intensity"), Value(3.0f));
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
  EXPECT_TRUE(edits.changed_materials().empty());
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

TEST_F(SceneEditsTest, PrimsThatAreNotThereAreLeftAlone) {
  SceneEdits edits(&scene);
  const hd::host::Prims prims = scene.GetPrims();
  EXPECT_NE(edits.set("/nowhere", row_of("disney_material", "ior"), 2.0), "");
  EXPECT_NE(edits.set(kPreview, row_of("disney_material", "ior"), 2.0), "");
  EXPECT_NE(edits.reset("/nowhere", "ior"), "");
  EXPECT_TRUE(scene.GetPrims() == prims);
  EXPECT_TRUE(edits.changed_materials().empty());
}

}  // namespace
}  // namespace alabaster::view
