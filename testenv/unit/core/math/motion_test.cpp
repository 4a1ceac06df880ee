#include "core/math/motion.h"

#include <gtest/gtest.h>

namespace alabaster {
namespace {

Matrix4d turned(double degrees) {
  return Matrix4d().setAxisAngle(Vec3d(0, 0, 1), degrees * kPiDouble / 180);
}
Matrix4d shifted(double x) {
  return Matrix4d().setTranslation(Vec3d(x, 0, 0));
}
Matrix4d scaled(double x, double y) {
  return Matrix4d().setScale(Vec3d(x, y, 1));
}

TEST(MotionSamples, RotationKeepsSizeBetweenSamples) {
  const TimeSamples<Matrix4d> samples{
      {0, 1}, {scaled(2, 2) * turned(10) * shifted(1), scaled(2, 2) * turned(100) * shifted(5)}};
  for (const double t : {0.0, 0.25, 0.5, 1.0}) {
    const Matrix4d expected = scaled(2, 2) * turned(10 + 90 * t) * shifted(1 + 4 * t);
    EXPECT_TRUE(interpolate(samples, t).equalWithAbsError(expected, 1e-12)) << t;
  }
}

TEST(MotionSamples, BeyondTheSamplesThingsStandStill) {
  const TimeSamples<Matrix4d> samples{{-1, 1}, {shifted(1), shifted(2)}};
  EXPECT_EQ(interpolate(samples, -7), shifted(1));
  EXPECT_EQ(interpolate(samples, 7), shifted(2));
  EXPECT_EQ(even_poses(samples, {2, 3}), std::vector<Matrix4d>{shifted(2)});
  EXPECT_EQ(even_poses(samples, {0, 0}).size(), 1u);
  EXPECT_EQ(even_poses({{0, 1}, {shifted(1), shifted(1)}}, {0, 1}).size(), 1u) << "nothing changes";
}

TEST(MotionSamples, ShearAndMirroringAreKept) {
  Matrix4d sheared = scaled(1, 3) * turned(30) * scaled(2, 1);
  for (const double sign : {1.0, -1.0}) {
    const Matrix4d a = scaled(sign, 1) * sheared;
    EXPECT_TRUE(interpolate({{0, 1}, {a, a * turned(40)}}, 0.5).equalWithAbsError(a * turned(20), 1e-10));
  }
}

TEST(MotionSamples, SingularMatricesAreInterpolatedByEntry) {
  const Matrix4d flat = scaled(0, 1), mirrored = scaled(-1, 1);
  EXPECT_EQ(interpolate({{0, 1}, {flat, turned(90)}}, 0.5), flat * 0.5 + turned(90) * 0.5);
  EXPECT_EQ(interpolate({{0, 1}, {mirrored, turned(90)}}, 0.5), mirrored * 0.5 + turned(90) * 0.5);
}

TEST(MotionSamples, EvenPosesHaveTheSamplesAmongThem) {
  EXPECT_EQ(even_pose_count({0, 1}, {0, 1}, 65), 2u);
  EXPECT_EQ(even_pose_count({0, 0.5, 1}, {0, 1}, 65), 3u);
  EXPECT_EQ(even_pose_count({-1, 0, 1}, {-0.25, 0.25}, 65), 3u);
  EXPECT_EQ(even_pose_count({0, 0.2, 0.5, 1}, {0, 1}, 65), 11u);
  EXPECT_EQ(even_pose_count({0, 0.123456, 1}, {0, 1}, 33), 33u) << "as near as may be";
  const auto poses = even_poses({{0, 0.25, 1}, {shifted(0), shifted(8), shifted(0)}}, {0, 1});
  ASSERT_EQ(poses.size(), 5u);
  EXPECT_EQ(poses[1], shifted(8));
}

// Linear interpolation between two poses shrinks what turns.
TEST(MotionSamples, APoseTurnsByAFewDegreesFromTheLast) {
  const auto poses = even_poses({{0, 1}, {turned(0), turned(90)}}, {0, 1});
  EXPECT_EQ(poses.size(), 31u);
  std::vector<Affine> maps;
  for (const Matrix4d& pose : poses) maps.push_back(to_affine(pose));
  for (int i = 0; i <= 1000; ++i) {
    const Vec3f p = posed(maps, static_cast<float>(i) / 1000).point({1, 0, 0});
    EXPECT_NEAR(length(p), 1, 4e-4);
    EXPECT_NEAR(std::atan2(p.y, p.x), i * kPiDouble / 2000, 1e-4);
  }
  EXPECT_EQ(
      even_poses({{0, 1, 2, 3, 4}, {turned(0), turned(170), turned(340), turned(510), turned(680)}}, {0, 4}).size(),
      kMostPoses);
}

TEST(MotionSamples, InverseMapsBack) {
  const Affine map = to_affine(scaled(0.1, 20) * turned(77) * shifted(12));
  const Affine back = inverse(map);
  const Vec3f p(0.3f, -0.2f, 4);
  EXPECT_LT(length(back.point(map.point(p)) - p), 2e-4f);
  EXPECT_LT(length(back.vector(map.vector(p)) - p), 2e-5f);
}

TEST(MotionSamples, LeastStretchBetweenMapsBoundsThemAll) {
  const auto maps = {std::pair(turned(0), turned(90)), std::pair(scaled(1, 1), scaled(0.01, 3) * turned(20)),
                     std::pair(scaled(-1, 1), scaled(-2, 1) * turned(3))};
  for (const auto& [from, to] : maps) {
    const Affine a = to_affine(from), b = to_affine(to);
    const float bound = least_stretch_between(a, b);
    float least = least_stretch(a);
    for (int i = 0; i <= 100; ++i) least = std::min(least, least_stretch(posed({a, b}, static_cast<float>(i) / 100)));
    EXPECT_LE(bound, least);
    EXPECT_GE(bound, 0.7f * least);
  }
  EXPECT_EQ(least_stretch_between(to_affine(scaled(1, 1)), to_affine(scaled(-1, 1))), 0) << "turns inside out";
}

}  // namespace
}  // namespace alabaster
