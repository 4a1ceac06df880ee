// Contract 0.2: a pass draws by the render tags, the collection and the camera that Execute is given. And light links
// (1.3).
#include <gtest/gtest.h>

#include "testenv/conformance/scenes.h"

namespace conformance {
namespace {

const std::vector<Token> kDrawn = {"geometry", "render"};

// Purposes may be toggled without a Sync (OpenUSD#801, arnold#843).
TEST(Purposes, PurposesAreToggledWithoutASync) {
  Host host;
  add_halves(host);
  host.mesh("/left").tag = "proxy";
  const Picture without = host.render();
  EXPECT_TRUE(near(without.color(-0.5, 0), kBlack));
  host.scene.take_pulls();
  for (int i = 0; i < 3; ++i) {
    host.state.renderTags = {"geometry", "render", "proxy"};
    const Picture with = host.render();
    EXPECT_TRUE(near(with.color(-0.5, 0), kRed) && near(with.color(0.5, 0), kGreen));
    host.state.renderTags = {"proxy"};
    EXPECT_TRUE(near(host.render().color(0.5, 0), kBlack));
    host.state.renderTags = kDrawn;
    EXPECT_TRUE(host.render() == without);
  }
  EXPECT_TRUE(host.scene.take_pulls().empty());
}

TEST(Purposes, ChangedPurposeOfAMeshIsDrawn) {
  Host host;
  add_halves(host);
  host.render();
  for (int i = 0; i < 3; ++i) {
    host.mesh("/left", dirty::kRenderTag).tag = "guide";
    EXPECT_TRUE(near(host.render().color(-0.5, 0), kBlack));
    host.mesh("/left", dirty::kRenderTag).tag = "render";
    EXPECT_TRUE(near(host.render().color(-0.5, 0), kRed));
  }
}

// A toggle crashed with nested instancers (arnold#2628).
TEST(Purposes, PurposesOfNestedInstancesAreToggled) {
  Host host;
  host.mesh("/tile") = rectangle(0, 0, 0.25, 0.25);
  host.mesh("/tile").tag = "guide";
  host.mesh("/tile").instancer = "/inner";
  InstancerData& inner = host.instancer("/inner");
  inner.parent = "/outer";
  inner.primvars["hydra:instanceTranslations"] = Array<Vec3f>{{0, 0, 0}, {0.5f, 0, 0}};
  inner.indices["/tile"] = {0, 1};
  InstancerData& outer = host.instancer("/outer");
  outer.primvars["hydra:instanceTranslations"] = Array<Vec3f>{{0, 0, 0}, {0, 0.5f, 0}};
  outer.indices["/inner"] = {0, 1};
  for (int i = 0; i < 3; ++i) {
    host.state.renderTags = {"guide"};
    EXPECT_EQ(host.render("instanceId").id(0.625, 0.625), 3);
    host.state.renderTags = kDrawn;
    EXPECT_EQ(host.render("instanceId").id(0.625, 0.625), -1);
  }
}

TEST(Collections, ChooseByPath) {
  Host host;
  add_halves(host);
  host.render();
  host.scene.take_pulls();
  host.state.collection.rootPaths = {"/left"};
  Picture picture = host.render();
  EXPECT_TRUE(near(picture.color(-0.5, 0), kRed) && near(picture.color(0.5, 0), kBlack));
  host.state.collection = {{"/"}, {"/left"}};
  picture = host.render();
  EXPECT_TRUE(near(picture.color(-0.5, 0), kBlack) && near(picture.color(0.5, 0), kGreen));
  EXPECT_TRUE(host.scene.take_pulls().empty());
}

// Viewports have matrices and no prim; lens and shutter are lost in other delegates (mh#509).
TEST(CameraPrim, FreeCameraIsUsed) {
  Host host;
  add_noisy_scene(host);
  Camera& prim = host.camera();
  prim.parameters["fStop"] = 2.0f, prim.parameters["focusDistance"] = 1.5f;
  const Picture of_prim = host.render();
  host.state.freeCamera = CameraDescription{prim.transform, prim.parameters, {}};
  host.state.camera = "/no such camera";
  EXPECT_TRUE(host.render() == of_prim);
  host.state.freeCamera->transform = moved(0.5, 0, 2);
  EXPECT_FALSE(host.render() == of_prim);
}

// Geometry has categories, a light names one (OpenUSD#1388 for instances).
TEST(LightCategories, NameCategories) {
  Host host;
  host.mesh("/left") = rectangle(-1, -1, 0, 1);
  host.mesh("/right") = rectangle(0, -1, 1, 1);
  host.light("/dome", "domeLight").parameters = {{"intensity", 1.0f}};
  const Picture both = host.render();
  host.mesh("/left", dirty::kCategories).categories = {"lit"};
  host.light("/dome", "domeLight", dirty::kParams).parameters["lightLink"] = Token("lit");
  const Picture linked = host.render();
  EXPECT_EQ(linked.color(-0.5, 0), both.color(-0.5, 0));
  EXPECT_TRUE(near(linked.color(0.5, 0), kBlack));
  host.light("/dome", "domeLight", dirty::kParams).parameters.erase("lightLink");
  EXPECT_TRUE(host.render() == both);
}

}  // namespace
}  // namespace conformance
