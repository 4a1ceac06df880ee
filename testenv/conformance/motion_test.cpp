// Contract 0.2, 1.3 (motion), 1.5: the shutter is known only at Execute.
#include <gtest/gtest.h>

#include <algorithm>

#include "testenv/conformance/scenes.h"

namespace conformance {
namespace {

// A square of [-.5, .5] that moves from x = 0 to x = .5 in one frame and glows.
struct MovingHost : Host {
  MovingHost() : Host(16, 16, {{"samples", 64}}) {
    material("/red") = glow(kRed);
    Mesh& square = mesh("/square") = rectangle(-0.5, -0.5, 0.5, 0.5);
    square.material = "/red";
    square.motion = {{0, 1}, {Matrix4d(), moved(0.5, 0)}};
  }
  void open(double from, double to) {
    Camera& lens = camera(dirty::kParams);
    lens.parameters["shutterOpen"] = from, lens.parameters["shutterClose"] = to;
  }
};

// The share of the shutter [0, 1] in which the square covers x, where it goes from x = 0 to `end`.
double share(double x, double end = 0.5) {
  const double from = (x - 0.5) / end, to = (x + 0.5) / end;
  return std::max(0.0, std::min(1.0, to) - std::max(0.0, from));
}

void expect_blur(const Picture& picture, double end = 0.5) {
  for (int x = 0; x < 16; ++x) {
    const double at = -1 + (x + 0.5) / 8;
    EXPECT_NEAR(picture.number(x, 8, 3), share(at, end), 0.15) << "column " << x;
  }
}

// First frame without motion blur (arnold#1844); here with one Sync and no other frame before.
TEST(MovingPrims, TheFirstFrameIsBlurred) {
  MovingHost host;
  host.open(0, 1);
  expect_blur(host.render());
}

TEST(MovingPrims, AShutterChangeNeedsNoSyncOfMeshes) {
  MovingHost host, fresh;
  const Picture still = host.render();
  EXPECT_EQ(still.number(13, 8, 3), 0);
  host.scene.take_pulls();
  host.open(0, 1);
  const Picture blurred = host.render();
  EXPECT_EQ(host.scene.take_pulls(), std::vector<std::string>{"camera /camera"});
  fresh.open(0, 1);
  EXPECT_TRUE(blurred == fresh.render());
  host.open(0, 0);
  EXPECT_TRUE(host.render() == still);
}

// Blur was lost after a camera move (arnold#2268, #1996, #2481).
TEST(MovingPrims, BlurOutlastsACameraMove) {
  MovingHost host;
  host.open(0, 1);
  const Picture blurred = host.render();
  host.camera(dirty::kTransform).transform = moved(0.25, 0, 2);
  host.render();
  host.camera(dirty::kTransform).transform = moved(0, 0, 2);
  EXPECT_TRUE(host.render() == blurred);
}

// Samples may lie outside of the shutter, and need not be evenly spaced (OpenUSD#3478, arnold#2168, #1477).
TEST(MovingPrims, SamplesMayLieOutsideOfTheShutter) {
  MovingHost host;
  host.open(0, 1);
  host.mesh("/square").motion = {{-2, -0.5, 0.25, 3}, {moved(-1, 0), moved(-0.25, 0), moved(0.125, 0), moved(1.5, 0)}};
  expect_blur(host.render());
}

TEST(MovingPrims, PointsAreBlurred) {
  MovingHost host;
  host.open(0, 1);
  Mesh& square = host.mesh("/square");
  square.motion = {};
  square.moving_points = {
      {0, 1},
      {rectangle(-0.5, -0.5, 0.5, 0.5).primvars["points"].value, rectangle(0, -0.5, 1, 0.5).primvars["points"].value}};
  expect_blur(host.render());
}

TEST(MovingPrims, TheCameraIsBlurred) {
  MovingHost host;
  host.open(0, 1);
  host.mesh("/square").motion = {};
  host.camera().motion = {{0, 1}, {moved(0, 0, 2), moved(-0.5, 0, 2)}};
  expect_blur(host.render());
}

// Times that do not increase, or are no numbers: one fault more or less, but a picture.
TEST(MovingPrims, TimesThatAreNoTimesLeaveThingsStanding) {
  MovingHost host;
  const Picture still = host.render();
  host.open(0, 1);
  for (const std::vector<double>& times : {std::vector<double>{1, 0}, {0, 0}, {0, std::nan("")}, {0}}) {
    host.mesh("/square").motion = {times, {Matrix4d(), moved(0.5, 0)}};
    const Picture picture = host.render();
    EXPECT_EQ(host.pass->GetState(), PassState::converged);
    EXPECT_EQ(picture.number(8, 8, 3), 1);
  }
  host.open(1, 0);
  EXPECT_EQ(host.render().number(8, 8, 3), 1) << "a shutter that closes before it opens";
}

}  // namespace
}  // namespace conformance
