// Contract 1.3, 1.6: ids and depth of the closest sample; instance ids flattened, the innermost fastest.
#include <gtest/gtest.h>

#include <set>

#include "testenv/conformance/scenes.h"

namespace conformance {
namespace {

std::set<int32_t> integers(const Picture& picture) {
  std::set<int32_t> all;
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) all.insert(picture.integer(x, y));
  return all;
}

// rpr#295. Three meshes whose ids are far apart lie behind each other as gratings, finer than pixels.
// promise: pipeline.aov.ids
TEST(Ids, AreNeverAveraged) {
  Host host(16, 16, {{"samples", 16}});
  std::set<int32_t> known = {-1};
  for (int i = 0; i < 40; ++i) {
    const std::string name = "/strip" + std::to_string(i);
    host.mesh(name) = rectangle(-0.9 + 0.045 * i, -0.8, -0.9 + 0.045 * i + 0.035, 0.8, 1, 0.001 * (i % 3));
    if (i % 7 == 0) known.insert(host.prim_id(name));
  }
  for (int i = 0; i < 40; ++i)
    if (i % 7) host.remove("/strip" + std::to_string(i));
  host.buffer("primId");
  const std::set<int32_t> seen = integers(host.render("primId"));
  EXPECT_EQ(seen, known);
}

// promise: pipeline.aov.ids
TEST(Ids, ZeroIsAnIdAndTheBackgroundIsMinusOne) {
  Host host;
  host.mesh("/left") = rectangle(-1, -1, 0, 1);
  ASSERT_EQ(host.prim_id("/left"), 0);
  for (const char* aov : {"primId", "instanceId", "elementId"}) {
    const Picture ids = host.render(aov);
    EXPECT_EQ(ids.id(0.5, 0), -1) << aov;
    EXPECT_EQ(ids.id(-0.5, 0), 0) << aov;
  }
}

TEST(Ids, ElementsAreFacesOfTheCage) {
  Host host;
  host.mesh("/grid") = rectangle(-1, -1, 1, 1, 4);
  Picture ids = host.render("elementId");
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) EXPECT_EQ(ids.id(-0.75 + 0.5 * i, -0.75 + 0.5 * j), 4 * j + i);
  host.mesh("/grid").topology.scheme = "bilinear";
  host.mesh("/grid").style.refineLevel = 2;
  ids = host.render("elementId");
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) EXPECT_EQ(ids.id(-0.75 + 0.5 * i, -0.75 + 0.5 * j), 4 * j + i) << "refined";
}

// DirtyPrimID: the host numbers its prims again.
TEST(Ids, ANewPrimIdIsSeen) {
  Host host;
  host.mesh("/left") = rectangle(-1, -1, 0, 1);
  host.mesh("/right") = rectangle(0, -1, 1, 1);
  EXPECT_EQ(host.render("primId").id(0.5, 0), host.prim_id("/right"));
  host.set_prim_id("/right", 1234567);
  EXPECT_EQ(host.render("primId").id(0.5, 0), 1234567);
}

// arnold#385: tumble pivots read depth and ids.
// promise: pipeline.aov.depth
TEST(Depth, IsOneWhereNothingIsAndThatOfTheClosestSample) {
  Host host(16, 16, {{"samples", 64}});
  host.camera().parameters["clippingRange"] = Vec2f(1, 5);
  // In every pixel of the left half the near mesh covers a part, at distance 1.5, the far one the rest, at 2.
  for (int i = 0; i < 16; ++i)
    host.mesh("/near" + std::to_string(i)) =
        rectangle(-0.75 + 0.75 * i / 16, -0.75, -0.75 + 0.75 * (i + 0.5) / 16, 0.75, 1, 0.5);
  host.mesh("/far") = rectangle(-1, -1, 0, 1);
  host.bind("depth"), host.bind("cameraDepth");
  const Picture depth = host.render("depth"), distance = read(host.buffer("cameraDepth"));
  EXPECT_EQ(depth.number(12, 8), 1);
  EXPECT_NEAR(distance.number(4, 8), 1.5, 1e-3) << "not a mean";
  EXPECT_NEAR(depth.number(4, 8), 5 * (1.5 - 1) / (1.5 * (5 - 1)), 1e-3);
}

}  // namespace
}  // namespace conformance
