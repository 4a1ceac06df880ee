// The camera as a mouse moves it.
#include "delegate/view/orbit_camera.h"

#include <gtest/gtest.h>

#include <cmath>

namespace alabaster::view {
namespace {

using hd::Matrix4d;
using hd::Vec3d;

constexpr double kRightAngle = M_PI / 2;

// At z = 5, looking at the origin.
Matrix4d front() {
  return Matrix4d().setTranslation(Vec3d(0, 0, 5));
}

Vec3d row(const Matrix4d& m, int i) {
  return {m[i][0], m[i][1], m[i][2]};
}

void expect_near(const Vec3d& a, const Vec3d& b, const char* what) {
  EXPECT_NEAR((a - b).length(), 0, 1e-9) << what << ": " << a << " instead of " << b;
}

// The arguments of point_at that give the point.
Vec3d seen_at(const Matrix4d& camera, const Sight& sight, const Vec3d& point) {
  Vec3d local;
  camera.inverse().multVecMatrix(point, local);
  const hd::Vec2d at = place_of(camera, sight, point).value_or(hd::Vec2d(-1));
  return {at.x, at.y, -local.z};
}

TEST(OrbitCamera, AQuarterTurnBringsTheCameraToTheSide) {
  const Matrix4d turned = orbited(front(), Vec3d(0), kRightAngle, 0);
  expect_near(turned.translation(), {5, 0, 0}, "place");
  expect_near(row(turned, 2), {1, 0, 0}, "back");
  expect_near(row(turned, 0), {0, 0, -1}, "right");
  expect_near(row(turned, 1), {0, 1, 0}, "up");
}

TEST(OrbitCamera, WhatIsBehindTheCameraHasNoPlaceInThePicture) {
  const Sight sight{false, 0.72, 0.48, 0, 0};
  EXPECT_TRUE(place_of(front(), sight, Vec3d(0, 0, 4.9)));
  EXPECT_FALSE(place_of(front(), sight, Vec3d(0, 0, 5.1)));
  EXPECT_FALSE(place_of(front(), sight, front().translation()));
}

TEST(OrbitCamera, APositivePitchRaisesTheCamera) {
  const Matrix4d raised = orbited(front(), Vec3d(0), 0, M_PI / 6);
  expect_near(raised.translation(), {0, 2.5, 5 * std::cos(M_PI / 6)}, "place");
  expect_near(row(raised, 2), raised.translation() / 5, "it still looks at the pivot");
}

TEST(OrbitCamera, TheAxisThatPointsUpIsTheScenes) {
  const Vec3d z(0, 0, 1);
  Matrix4d level;  // looks along +y, from the front of a scene with z up
  level.setAxisAngle(Vec3d(1, 0, 0), kRightAngle);
  level = level * Matrix4d().setTranslation(Vec3d(0, -5, 0));
  expect_near(orbited(level, Vec3d(0), kRightAngle, 0, z).translation(), {5, 0, 0}, "to the right");
  const Matrix4d raised = orbited(level, Vec3d(0), 0.4, M_PI / 6, z);
  EXPECT_NEAR(raised.translation().z, 2.5, 1e-9);
  EXPECT_NEAR(row(raised, 0).z, 0, 1e-9) << "level";
}

TEST(OrbitCamera, ThePivotStaysWhereItIsInThePicture) {
  const Vec3d pivot(0.7, -0.4, 1);
  const Sight sight{false, 0.72, 0.48};
  const Matrix4d camera = orbited(front(), Vec3d(0), 0.3, 0.2);
  const Vec3d before = seen_at(camera, sight, pivot);
  expect_near(seen_at(orbited(camera, pivot, 1.1, -0.5), sight, pivot), before, "pivot");
}

TEST(OrbitCamera, NeitherPoleIsPassedAndTheHorizonStaysLevel) {
  for (const double pitch : {10.0, -10.0}) {
    Matrix4d camera = front();
    for (int i = 0; i < 50; ++i) camera = orbited(camera, Vec3d(0), 0.1, pitch / 50);
    EXPECT_GT(row(camera, 1).y, 0) << "not upside down";
    EXPECT_NEAR(row(camera, 0).y, 0, 1e-9) << "level";
    EXPECT_NEAR(std::abs(std::asin(row(camera, 2).y)), 89.5 * M_PI / 180, 1e-6) << "as far as it goes";
    EXPECT_NEAR(camera.translation().length(), 5, 1e-9);
  }
}

// A file's own camera may look straight down: it must not jump when the mouse first moves.
TEST(OrbitCamera, ACameraThatLooksStraightDownTurnsWithoutAJump) {
  const Matrix4d down = orbited(front(), Vec3d(0), 0, 10);
  Matrix4d straight;
  straight.setAxisAngle(Vec3d(1, 0, 0), -kRightAngle);
  straight = straight * Matrix4d().setTranslation(Vec3d(0, 5, 0));
  const Matrix4d moved = orbited(straight, Vec3d(0), 0.01, 0);
  EXPECT_LT((moved.translation() - straight.translation()).length(), 1e-6);
  EXPECT_GT(row(moved, 2).y, 1 - 1e-9);
  EXPECT_GT(down.translation().y, 4.9);
}

TEST(OrbitCamera, APanByTheSightMovesAPointAcrossThePicture) {
  const Sight sight{false, 0.72, 0.48};
  const Matrix4d camera = orbited(front(), Vec3d(0), 0.4, 0.3);
  const double depth = 3;
  const Vec3d point = point_at(camera, sight, 0.5, 0.5, depth);
  const Matrix4d moved = panned(camera, -0.25 * sight.width * depth, 0.125 * sight.height * depth);
  expect_near(seen_at(moved, sight, point), {0.75, 0.625, depth}, "place in the picture");
}

TEST(OrbitCamera, ADollyChangesTheDistanceByItsFactor) {
  const Vec3d pivot(1, 2, -3);
  const Matrix4d camera = orbited(front(), Vec3d(0), 0.4, 0.3);
  const Matrix4d near = dollied(camera, pivot, 0.25);
  expect_near(near.translation() - pivot, (camera.translation() - pivot) * 0.25, "offset");
  for (int i = 0; i < 3; ++i) expect_near(row(near, i), row(camera, i), "direction");
}

TEST(OrbitCamera, PointAtIsTheInverseOfThePicture) {
  for (const bool orthographic : {false, true}) {
    const Sight sight{orthographic, 0.72, 0.48};
    const Matrix4d camera = orbited(front(), Vec3d(0), -0.7, 0.5);
    for (const auto& [x, y, depth] : {std::array{0.0, 0.0, 1.0}, {0.5, 0.5, 4.0}, {0.9, 0.2, 0.01}})
      expect_near(seen_at(camera, sight, point_at(camera, sight, x, y, depth)), {x, y, depth}, "place");
  }
  EXPECT_GT(point_at(front(), {false, 1, 1}, 0.5, 0, 1).y, 0) << "the uppermost row is above";
}

hd::Framing picture(float width, float height) {
  return {{0, 0}, {width, height}, {0, 0, int(width), int(height)}, 1};
}

TEST(OrbitCamera, TheSightFollowsTheWindowPolicy) {
  hd::CameraDescription camera;  // 36 x 24 and 50, as the schema has them
  const auto vertically = sight_of(camera, picture(200, 100), hd::WindowPolicy::matchVertically);
  EXPECT_NEAR(vertically.height, 24.0 / 50, 1e-9);
  EXPECT_NEAR(vertically.width, 2 * 24.0 / 50, 1e-9);
  const auto horizontally = sight_of(camera, picture(200, 100), hd::WindowPolicy::matchHorizontally);
  EXPECT_NEAR(horizontally.width, 36.0 / 50, 1e-9);
  EXPECT_NEAR(horizontally.height, 18.0 / 50, 1e-9);
}

TEST(OrbitCamera, ZoomingMovesAPerspectiveCameraAndScalesAnOrthographicFilm) {
  hd::CameraDescription camera;
  camera.transform = front();
  zoom(&camera, Vec3d(0), 0.5);
  expect_near(camera.transform.translation(), {0, 0, 2.5}, "place");
  EXPECT_TRUE(camera.parameters.empty());

  camera.transform = front();
  camera.parameters["projection"] = hd::Token("orthographic");
  camera.parameters["horizontalAperture"] = 4.0f;
  camera.parameters["verticalAperture"] = 2.0f;
  zoom(&camera, Vec3d(0), 0.5);
  expect_near(camera.transform.translation(), {0, 0, 5}, "place");
  EXPECT_FLOAT_EQ(float(camera.parameters["horizontalAperture"].number_or(0)), 2);
  EXPECT_FLOAT_EQ(float(camera.parameters["verticalAperture"].number_or(0)), 1);
}

// A shift of 9 mm before 50 mm: the middle of the picture shows what is right of the axis.
TEST(OrbitCamera, AShiftedLensLooksBesideItsAxis) {
  hd::CameraDescription camera;
  camera.transform = front();
  camera.parameters["horizontalApertureOffset"] = 9.0f;
  camera.parameters["verticalApertureOffset"] = -3.0f;
  const Sight sight = sight_of(camera, picture(300, 200), hd::WindowPolicy::matchVertically);
  const Vec3d middle = point_at(camera.transform, sight, 0.5, 0.5, 5);
  expect_near(middle, {9.0 / 50 * 5, -3.0 / 50 * 5, 0}, "middle");
  expect_near(seen_at(orbited(camera.transform, middle, 0.8, 0.3), sight, middle), {0.5, 0.5, 5}, "pivot of a turn");
}

TEST(OrbitCamera, AnOrthographicZoomKeepsThePointUnderTheMouse) {
  hd::CameraDescription camera;
  camera.transform = orbited(front(), Vec3d(0), 0.4, 0.3);
  camera.parameters["projection"] = hd::Token("orthographic");
  camera.parameters["horizontalAperture"] = 4.0f;
  camera.parameters["verticalAperture"] = 2.0f;
  camera.parameters["horizontalApertureOffset"] = 0.5f;
  const auto sight = [&] { return sight_of(camera, picture(200, 100), hd::WindowPolicy::matchVertically); };
  const Vec3d point = point_at(camera.transform, sight(), 0.8, 0.3, 3);
  zoom(&camera, point, 0.5);
  expect_near(seen_at(camera.transform, sight(), point), {0.8, 0.3, 3}, "place");
}

}  // namespace
}  // namespace alabaster::view
