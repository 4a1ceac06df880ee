// Section 3, "Stale state": every edit is drawn, and nothing stays of a prim that was taken away.
#include <gtest/gtest.h>

#include "testenv/conformance/scenes.h"

namespace conformance {
namespace {

// A rectangle of 2 x 2 faces whose material shows displayColor.
Mesh& add_colored(Host& host) {
  host.material("/colors") = glow_of_display_color();
  Mesh& mesh = host.mesh("/mesh") = rectangle(-1, -1, 1, 1, 2);
  mesh.material = "/colors";
  return mesh;
}

Primvar color(const Vec3f& value) {
  return {Array<Vec3f>(std::vector<Vec3f>(9, value)), Interpolation::vertex, "color", {}};
}

// OpenUSD#906, #1316, #1004.
TEST(Primvars, AddedPrimvarsAreDrawn) {
  Host host;
  add_colored(host);
  EXPECT_FALSE(near(host.render().color(0.5, 0.5), kGreen));
  host.mesh("/mesh", dirty::kPrimvar).primvars["displayColor"] = color(kGreen);
  EXPECT_TRUE(near(host.render().color(0.5, 0.5), kGreen));
  host.mesh("/mesh", dirty::kPrimvar).primvars["displayColor"] = color(kBlue);
  EXPECT_TRUE(near(host.render().color(0.5, 0.5), kBlue));
}

TEST(Primvars, RemovedPrimvarsAreNotDrawn) {
  Host host;
  add_colored(host);
  const Picture without = host.render();
  host.mesh("/mesh", dirty::kPrimvar).primvars["displayColor"] = color(kGreen);
  EXPECT_FALSE(host.render() == without);
  host.mesh("/mesh", dirty::kPrimvar).primvars.erase("displayColor");
  EXPECT_TRUE(host.render() == without);
}

TEST(Primvars, MayChangeTheirInterpolationAndType) {
  Host host;
  add_colored(host);
  const auto set = [&](const Primvar& primvar) {
    host.mesh("/mesh", dirty::kPrimvar).primvars["displayColor"] = primvar;
    return host.render();
  };
  const Array<Vec3f> three = {kRed, kGreen, kBlue};
  EXPECT_TRUE(near(set(color(kGreen)).color(0.5, 0.5), kGreen));
  std::vector<int32_t> by_face;
  for (int face : {0, 1, 2, 1}) by_face.insert(by_face.end(), 4, face);
  const Picture indexed = set({three, Interpolation::faceVarying, "color", Array<int32_t>(by_face)});
  EXPECT_TRUE(near(indexed.color(-0.5, 0.5), kBlue) && near(indexed.color(0.5, 0.5), kGreen));
  const Picture varying = set({Array<Vec3f>(std::vector<Vec3f>(9, kRed)), Interpolation::varying, "color", {}});
  EXPECT_TRUE(near(varying.color(-0.5, 0.5), kRed));
  set({Array<std::string>{"red"}, Interpolation::constant, "color", {}});
  EXPECT_EQ(host.pass->GetState(), PassState::converged) << "a type that is no colour";
  EXPECT_TRUE(near(set(color(kBlue)).color(0.5, 0.5), kBlue)) << "and back";
}

TEST(Primvars, PointsAloneMayChange) {
  Host host;
  add_halves(host);
  host.render();
  host.mesh("/left", dirty::kPoints).primvars["points"] = rectangle(-1, 0, 0, 1).primvars["points"];
  const Picture picture = host.render();
  EXPECT_TRUE(near(picture.color(-0.5, 0.5), kRed));
  EXPECT_TRUE(near(picture.color(-0.5, -0.5), kBlack));
}

TEST(MaterialPrims, MayComeAfterTheirMesh) {
  Host host;
  host.mesh("/mesh") = rectangle(-1, -1, 1, 1);
  host.mesh("/mesh").material = "/late";
  host.render();
  host.scene.take_pulls();
  host.material("/late") = glow(kGreen);
  EXPECT_TRUE(near(host.render().color(0, 0), kGreen));
  EXPECT_EQ(host.scene.take_pulls(), std::vector<std::string>{"network /late"}) << "the mesh is not synced";
}

TEST(MaterialPrims, MayGoBeforeTheirMesh) {
  Host host;
  host.mesh("/mesh") = rectangle(-1, -1, 1, 1);
  host.mesh("/mesh").material = "/glow";
  const Picture without = host.render();
  host.material("/glow") = glow(kGreen);
  EXPECT_TRUE(near(host.render().color(0, 0), kGreen));
  host.remove("/glow");
  EXPECT_TRUE(host.render() == without);
  EXPECT_EQ(host.pass->GetState(), PassState::converged);
  host.remove("/mesh");
  EXPECT_EQ(host.render().number(8, 8, 3), 0);
}

// Rebinding must not cost a new mesh.
TEST(MaterialPrims, MayBeReboundAlone) {
  Host host;
  add_halves(host);
  host.render();
  host.scene.take_pulls();
  host.mesh("/left", dirty::kMaterialId).material = "/green";
  EXPECT_TRUE(near(host.render().color(-0.5, 0), kGreen));
  EXPECT_EQ(host.scene.take_pulls(), std::vector<std::string>{"material /left"});
  host.mesh("/left", dirty::kMaterialId).material = Path();
  EXPECT_FALSE(near(host.render().color(-0.5, 0), kGreen));
  host.mesh("/left", dirty::kMaterialId).material = "/red";
  EXPECT_TRUE(near(host.render().color(-0.5, 0), kRed));
}

// rpr#329, arnold#1158, #2547, #2568: a network of another shape fails to reach the mesh.
TEST(MaterialPrims, MayChangeTheirNetwork) {
  Host host;
  add_colored(host).primvars["displayColor"] = color(kBlue);
  EXPECT_TRUE(near(host.render().color(0, 0), kBlue));
  host.material("/colors", dirty::kResource) = glow(kRed);
  EXPECT_TRUE(near(host.render().color(0, 0), kRed)) << "without the reader";
  host.material("/colors", dirty::kResource) = glow_of_display_color();
  EXPECT_TRUE(near(host.render().color(0, 0), kBlue)) << "with it again";
  host.material("/colors", dirty::kResource) = MaterialNetwork();
  host.render();
  EXPECT_EQ(host.pass->GetState(), PassState::converged) << "without a terminal (arnold#751)";
  host.material("/colors", dirty::kResource) = glow(kGreen);
  EXPECT_TRUE(near(host.render().color(0, 0), kGreen));
}

// Networks that are not networks: cycles, loose ends, unknown nodes.
TEST(MaterialPrims, BrokenMaterialHarmsNoOther) {
  Host host;
  add_halves(host);
  const auto broken = [&](const std::function<void(MaterialNetwork&)>& spoil) {
    MaterialNetwork network = glow_of_display_color();
    spoil(network);
    host.material("/red", dirty::kResource) = network;
    EXPECT_TRUE(near(host.render().color(0.5, 0), kGreen));
    EXPECT_EQ(host.pass->GetState(), PassState::converged);
  };
  broken([](MaterialNetwork& n) { n.nodes["reader"].inputConnections["fallback"] = {{"surface", "out"}}; });
  broken([](MaterialNetwork& n) { n.nodes["surface"].inputConnections["emissiveColor"] = {{"surface", "out"}}; });
  broken([](MaterialNetwork& n) { n.nodes["surface"].inputConnections["emissiveColor"] = {{"no such node", "out"}}; });
  broken([](MaterialNetwork& n) { n.terminals["surface"] = {"no such node", "out"}; });
  broken([](MaterialNetwork& n) { n.nodes["surface"].nodeTypeId = "no such type"; });
  broken([](MaterialNetwork& n) { n.nodes["surface"].parameters["emissiveColor"] = "no colour"; });
  host.material("/red", dirty::kResource) = glow(kBlue);
  EXPECT_TRUE(near(host.render().color(-0.5, 0), kBlue));
}

// rpr#443.
TEST(MaterialPrims, MayBeEditedWhileTheirMeshIsHidden) {
  Host host;
  add_halves(host);
  host.render();
  host.mesh("/left", dirty::kVisibility).visible = false;
  host.render();
  host.material("/red", dirty::kResource) = glow(kBlue);
  EXPECT_TRUE(near(host.render().color(-0.5, 0), kBlack));
  host.mesh("/left", dirty::kVisibility).visible = true;
  EXPECT_TRUE(near(host.render().color(-0.5, 0), kBlue));
}

// arnold#95, #2467.
TEST(Visibility, HideAndShowAreDrawn) {
  Host host;
  add_halves(host);
  const Picture shown = host.render();
  for (int i = 0; i < 3; ++i) {
    host.mesh("/left", dirty::kVisibility).visible = false;
    EXPECT_TRUE(near(host.render().color(-0.5, 0), kBlack));
    host.mesh("/left", dirty::kVisibility).visible = true;
    EXPECT_TRUE(host.render() == shown);
  }
}

TEST(Visibility, EditsOfAHiddenMeshAreSeenOnceItIsShown) {
  Host host;
  add_halves(host);
  host.mesh("/left").visible = false;
  host.render();
  host.mesh("/left", dirty::kTransform).transform = moved(0, 1);
  host.mesh("/left", dirty::kMaterialId).material = "/green";
  host.render();
  host.mesh("/left", dirty::kVisibility).visible = true;
  const Picture picture = host.render();
  EXPECT_TRUE(near(picture.color(-0.5, 0.5), kGreen));
  EXPECT_TRUE(near(picture.color(-0.5, -0.5), kBlack));
}

TEST(Visibility, AHiddenLightGivesNoLight) {
  Host host;
  host.mesh("/mesh") = rectangle(-1, -1, 1, 1);
  host.light("/dome", "domeLight").parameters = {{"intensity", 1.0f}};
  EXPECT_GT(host.render().color(0, 0).x, 0.01f);
  host.light("/dome", "domeLight", dirty::kVisibility | dirty::kParams).visible = false;
  EXPECT_TRUE(near(host.render().color(0, 0), kBlack));
  host.light("/dome", "domeLight", dirty::kVisibility | dirty::kParams).visible = true;
  EXPECT_GT(host.render().color(0, 0).x, 0.01f);
}

TEST(Prims, RemovedPrimsAreNotDrawnAndMayComeBack) {
  Host host;
  add_halves(host);
  const Picture both = host.render();
  const Mesh left = host.mesh("/left");
  for (int i = 0; i < 3; ++i) {
    host.remove("/left");
    EXPECT_TRUE(near(host.render().color(-0.5, 0), kBlack));
    host.mesh("/left") = left;
    EXPECT_TRUE(host.render() == both);
  }
}

TEST(Prims, LightsThatAreRemovedAreGone) {
  Host host;
  add_noisy_scene(host);
  const Picture lit = host.render();
  const Light quad = host.light("/quad", "rectLight");
  host.remove("/quad");
  EXPECT_FALSE(host.render() == lit);
  host.light("/quad", "rectLight") = quad;
  EXPECT_TRUE(host.render() == lit);
}

}  // namespace
}  // namespace conformance
