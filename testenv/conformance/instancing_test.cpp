// Contract 1.3 (instancing), section 3 "Instancing": places and ids, worked out by hand.
#include <gtest/gtest.h>

#include <cmath>

#include "testenv/conformance/scenes.h"

namespace conformance {
namespace {

const float kHalf = std::sqrt(0.5f);

// A tile of [0, .25] x [0, .25] that glows red.
Mesh& add_tile(Host& host) {
  host.material("/red") = glow(kRed);
  Mesh& tile = host.mesh("/tile") = rectangle(0, 0, 0.25, 0.25);
  tile.material = "/red";
  tile.instancer = "/instancer";
  return tile;
}

Array<Vec3f> row(int count, float step = 0.5f) {
  std::vector<Vec3f> places;
  for (int i = 0; i < count; ++i) places.emplace_back(step * float(i), 0, 0);
  return places;
}

int pixels_of(const Picture& ids) {
  int count = 0;
  for (int y = 0; y < ids.height; ++y)
    for (int x = 0; x < ids.width; ++x) count += ids.integer(x, y) >= 0;
  return count;
}

// The tile's centre (.125, .125): prototype x + .25 -> (.375, .125); M y + .125 -> (.375, .25); S x 2 -> (.75, .5);
// R 90 degrees about z -> (-.5, .75); T x - .25 -> (-.75, .75); instancer y - 1.25 -> (-.75, -.5).
TEST(Instances, TheOrderIsPrototypeMatrixScaleRotationTranslationInstancer) {
  for (const Value& rotation :
       {Value(Array<Quatf>{Quatf(kHalf, 0, 0, kHalf)}), Value(Array<Vec4f>{{kHalf, 0, 0, kHalf}})}) {
    Host host;
    add_tile(host).transform = moved(0.25, 0);
    InstancerData& instancer = host.instancer("/instancer");
    instancer.primvars = {{"hydra:instanceTransforms", Array<Matrix4d>{moved(0, 0.125)}},
                          {"hydra:instanceScales", Array<Vec3f>{{2, 2, 2}}},
                          {"hydra:instanceRotations", rotation},
                          {"hydra:instanceTranslations", Array<Vec3f>{{-0.25f, 0, 0}}}};
    instancer.indices["/tile"] = {0};
    instancer.transform = moved(0, -1.25);
    const Picture ids = host.render("primId");
    EXPECT_EQ(pixels_of(ids), 16);
    for (double x : {-0.95, -0.55})
      for (double y : {-0.7, -0.3}) EXPECT_EQ(ids.id(x, y), host.prim_id("/tile")) << x << " " << y;
  }
}

// Two outer places, the upper of which is turned by half a turn; three inner ones, drawn as {2, 0}.
// instanceId = outer * 2 + number in {2, 0} (OpenUSD#1196, #713, #1343).
TEST(Instances, NestedOnesHaveTheirPlaceAndId) {
  Host host;
  add_tile(host).instancer = "/inner";
  InstancerData& inner = host.instancer("/inner");
  inner.parent = "/outer";
  inner.primvars["hydra:instanceTranslations"] = row(3);
  inner.indices["/tile"] = {2, 0};
  inner.transform = moved(-1, -0.75);
  InstancerData& outer = host.instancer("/outer");
  outer.primvars["hydra:instanceTranslations"] = Array<Vec3f>{{0, 0, 0}, {0, 0.25f, 0}};
  outer.primvars["hydra:instanceRotations"] = Array<Quatf>{Quatf(1, 0, 0, 0), Quatf(0, 0, 0, 1)};
  outer.indices["/inner"] = {0, 1};
  const Picture ids = host.render("instanceId");
  EXPECT_EQ(pixels_of(ids), 16);
  EXPECT_EQ(ids.id(0.125, -0.625), 0);
  EXPECT_EQ(ids.id(-0.875, -0.625), 1);
  EXPECT_EQ(ids.id(-0.125, 0.875), 2);
  EXPECT_EQ(ids.id(0.875, 0.875), 3);
  EXPECT_EQ(ids.id(-0.375, -0.625), -1) << "index 1 is not drawn";
}

// arnold#18: the prototype was drawn as well as its instances.
TEST(Instances, ThePrototypeIsNotDrawnByItself) {
  Host host;
  add_tile(host);
  InstancerData& instancer = host.instancer("/instancer");
  instancer.primvars["hydra:instanceTranslations"] = Array<Vec3f>{{0.5f, 0.5f, 0}};
  instancer.indices["/tile"] = {0};
  const Picture ids = host.render("primId");
  EXPECT_EQ(ids.id(0.125, 0.125), -1);
  EXPECT_EQ(ids.id(0.625, 0.625), host.prim_id("/tile"));
}

// arnold#2557, #2225, #2129: an instancer without instances crashed, or left a ghost.
TEST(Instances, AnInstancerMayHaveNone) {
  Host host;
  add_tile(host);
  host.instancer("/instancer");
  EXPECT_EQ(pixels_of(host.render("primId")), 0);
  host.instancer("/instancer").primvars["hydra:instanceTranslations"] = row(2);
  host.instancer("/instancer").indices["/tile"] = {0, 1};
  host.mark("/tile", dirty::kInstanceIndex);
  EXPECT_EQ(pixels_of(host.render("primId")), 8);
  host.instancer("/instancer").indices["/tile"] = {};
  host.mark("/tile", dirty::kInstanceIndex);
  EXPECT_EQ(pixels_of(host.render("primId")), 0);
  host.instancer("/instancer").primvars = {};
  EXPECT_EQ(pixels_of(host.render("primId")), 0);
}

TEST(Instances, MovedInstanceIsDrawn) {
  Host host;
  add_tile(host);
  InstancerData& instancer = host.instancer("/instancer");
  instancer.primvars["hydra:instanceTranslations"] = row(2);
  instancer.indices["/tile"] = {0, 1};
  host.render("primId");
  host.scene.take_pulls();
  host.instancer("/instancer", dirty::kPrimvar).primvars["hydra:instanceTranslations"] =
      Array<Vec3f>{{0, 0, 0}, {0.5f, -0.5f, 0}};
  const Picture ids = host.render("primId");
  EXPECT_GE(ids.id(0.625, -0.375), 0);
  EXPECT_EQ(ids.id(0.625, 0.125), -1);
  for (const std::string& pull : host.scene.take_pulls()) EXPECT_EQ(pull.find("/tile"), std::string::npos) << pull;
}

TEST(Instances, IndicesOutOfRangeAreLeftOutAndKeepTheirNumbers) {
  Host host;
  add_tile(host);
  InstancerData& instancer = host.instancer("/instancer");
  instancer.primvars["hydra:instanceTranslations"] = row(2);
  instancer.indices["/tile"] = {0, 9, -1, 1};
  const Picture ids = host.render("instanceId");
  EXPECT_EQ(pixels_of(ids), 8);
  EXPECT_EQ(ids.id(0.125, 0.125), 0);
  EXPECT_EQ(ids.id(0.625, 0.125), 3);
}

TEST(Instances, AHiddenPrototypeHasNone) {
  Host host;
  add_tile(host);
  InstancerData& instancer = host.instancer("/instancer");
  instancer.primvars["hydra:instanceTranslations"] = row(2);
  instancer.indices["/tile"] = {0, 1};
  EXPECT_EQ(pixels_of(host.render("primId")), 8);
  host.mesh("/tile", dirty::kVisibility).visible = false;
  EXPECT_EQ(pixels_of(host.render("primId")), 0);
}

// An instancer that goes before its prototype, one that comes after it, and instancers that contain each other.
TEST(Instances, InstancersComeAndGoInAnyOrder) {
  Host host;
  add_tile(host);
  EXPECT_EQ(pixels_of(host.render("primId")), 0) << "no instancer yet";
  InstancerData data;
  data.primvars["hydra:instanceTranslations"] = row(2);
  data.indices["/tile"] = {0, 1};
  host.instancer("/instancer") = data;
  host.mark("/tile", dirty::kInstancer | dirty::kInstanceIndex);
  EXPECT_EQ(pixels_of(host.render("primId")), 8);
  host.remove("/instancer");
  EXPECT_EQ(pixels_of(host.render("primId")), 0);
  host.instancer("/instancer") = data;
  host.instancer("/instancer").parent = "/other";
  host.instancer("/other").parent = "/instancer";
  host.render("primId");
  EXPECT_EQ(host.pass->GetState(), PassState::converged);
}

}  // namespace
}  // namespace conformance
