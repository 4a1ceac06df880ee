// Contract 1.4, section 3: subsets, holes, sides and refinement of whole meshes.
#include <gtest/gtest.h>

#include <cmath>

#include "testenv/conformance/scenes.h"

namespace conformance {
namespace {

// A grid of 2 x 2 faces, numbered by rows from below, with colours by subset.
Host& four_faces(Host& host) {
  host.material("/red") = glow(kRed);
  host.material("/green") = glow(kGreen);
  host.mesh("/grid") = rectangle(-1, -1, 1, 1, 2);
  host.mesh("/grid").material = "/red";
  return host;
}

// Uncovered faces were dropped; they have the mesh's own material.
TEST(Subsets, FacesOfNoSubsetHaveTheMeshsMaterial) {
  Host host;
  four_faces(host).mesh("/grid").topology.geomSubsets = {{"/grid/a", "/green", {1}}};
  const Picture picture = host.render();
  EXPECT_TRUE(near(picture.color(0.5, -0.5), kGreen));
  EXPECT_TRUE(near(picture.color(-0.5, -0.5), kRed));
  EXPECT_TRUE(near(picture.color(-0.5, 0.5), kRed));
}

// As hdSt/meshTopology.cpp cleans them.
TEST(Subsets, FacesOutOfRangeAndEmptyMaterialsAreLeftOut) {
  Host host;
  four_faces(host).mesh("/grid").topology.geomSubsets = {
      {"/grid/a", "/green", {-1, 1, 4, 2147483647}}, {"/grid/b", Path(), {0}}, {"/grid/c", "/green", {}}};
  const Picture picture = host.render();
  EXPECT_TRUE(near(picture.color(0.5, -0.5), kGreen));
  EXPECT_TRUE(near(picture.color(-0.5, -0.5), kRed));
}

// OpenUSD#1749, and a limit of 255 that another delegate has.
TEST(Subsets, MayBeMany) {
  Host host(64, 64);
  host.material("/red") = glow(kRed);
  host.material("/green") = glow(kGreen);
  Mesh& grid = host.mesh("/grid") = rectangle(-1, -1, 1, 1, 32);
  grid.material = "/red";
  for (int face = 0; face < 1024; face += 2)
    grid.topology.geomSubsets.push_back({"/grid/" + std::to_string(face), (face / 32) % 2 ? "/red" : "/green", {face}});
  const Picture picture = host.render();
  int wrong = 0;
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 32; ++x) {
      const bool green = x % 2 == 0 && y % 2 == 0;
      wrong += std::abs(picture.number(2 * x, 2 * y, 1) - (green ? kGreen.y : kRed.y)) > 2e-3f;
    }
  EXPECT_EQ(wrong, 0) << "of 1024 faces";
}

TEST(Subsets, AnEditOfThemAloneIsSeen) {
  Host host;
  four_faces(host);
  host.render();
  host.mesh("/grid", dirty::kTopology).topology.geomSubsets = {{"/grid/a", "/green", {3}}};
  EXPECT_TRUE(near(host.render().color(0.5, 0.5), kGreen));
  host.mesh("/grid", dirty::kTopology).topology.geomSubsets = {};
  EXPECT_TRUE(near(host.render().color(0.5, 0.5), kRed));
}

TEST(Meshes, HolesAreHoles) {
  for (const char* scheme : {"none", "catmullClark", "bilinear"}) {
    Host host;
    Mesh& grid = four_faces(host).mesh("/grid");
    grid.topology.scheme = scheme;
    grid.style.refineLevel = 2;
    grid.topology.holeIndices = {2};
    const Picture picture = host.render();
    EXPECT_TRUE(near(picture.color(-0.5, 0.5), kBlack)) << scheme;
    EXPECT_TRUE(near(picture.color(0.5, 0.5), kRed)) << scheme;
  }
}

// The winding, and nothing else, says which side is the front (arnold#2099).
TEST(Meshes, SingleSidedFacesAreSeenFromTheFront) {
  Host host;
  Mesh& grid = four_faces(host).mesh("/grid");
  const auto is_drawn = [&] { return near(host.render().color(0.5, 0.5), kRed); };
  EXPECT_TRUE(is_drawn());
  host.mesh("/grid").double_sided = false;
  EXPECT_TRUE(is_drawn());
  host.mesh("/grid").topology.orientation = "leftHanded";
  EXPECT_FALSE(is_drawn());
  host.mesh("/grid").double_sided = true;
  EXPECT_TRUE(is_drawn());
  grid.topology.orientation = "rightHanded";
}

// arnold#931: level 8 and above, and no final picture at all.
TEST(Meshes, TheHighestRefineLevelIsDrawn) {
  Host host;
  Mesh& mesh = host.mesh("/cage") = rectangle(-0.9, -0.9, 0.9, 0.9);
  host.material("/red") = glow(kRed);
  mesh.material = "/red";
  mesh.topology.scheme = "bilinear";
  mesh.style.refineLevel = 99;
  EXPECT_TRUE(near(host.render().color(0.1, 0.1), kRed));
}

}  // namespace
}  // namespace conformance
