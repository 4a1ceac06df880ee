// Subsurface scattering where numbers are very large, very small or far from the origin.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "testenv/support/medium_bodies.h"

namespace alabaster {
namespace {

using testing::box_mesh;
using testing::expect_same;
using testing::MeanError;
using testing::medium_only;
using testing::merged;
using testing::request_of;
using testing::SceneBuilder;

// A set, overlapping shells, an open mesh and coarse smooth normals, all lengths times 2^k.
std::vector<float> picture_of_all(int exponent) {
  const auto s = static_cast<float>(std::ldexp(1.0, exponent));
  SceneBuilder b;
  const auto material = b.material(medium_only(0.9f, 0.3f * s));
  const auto at = [&](double x, double y) {
    return Matrix4d().setTranslation(Vec3d(x, y, 0) * static_cast<double>(s));
  };
  const auto ball = b.prototype(testing::sphere_mesh(s, 8, true));
  for (const double x : {-1.5, -0.5}) b.add(ball, material, at(x, 1));
  for (auto& instance : b.description.instances) instance.subsurface_set = "pair";
  b.add(b.prototype(
            merged(box_mesh({0, 0, 0}, Vec3f(1, 1, 1) * s), box_mesh(Vec3f(0.5f, 0.5f, 0.5f) * s, Vec3f(2, 1, 1) * s))),
        material, at(0.8, 0.2));
  b.add(b.prototype(testing::plane_mesh(8 * s)), material, at(0, -1));
  LightDescription key;
  key.type = LightType::sphere;
  key.radius = 0.5f * s;
  key.intensity = 60;
  key.light_to_world.setTranslation(Vec3d(-1, 4, 3) * static_cast<double>(s));
  b.add(key);
  const CameraParameters camera =
      testing::look_at(Vec3d(0, 1, 6) * static_cast<double>(s), Vec3d(0, 0.5, 0) * static_cast<double>(s), 45);
  return testing::render(request_of(&b, camera, 2, 16))->resolve_float(Aov::color);
}

TEST(Extremes, PowersOfTwoChangeNoBit) {
  const std::vector<float> expected = picture_of_all(0);
  for (int exponent = -20; exponent <= 20; ++exponent)
    EXPECT_EQ(picture_of_all(exponent), expected) << "2^" << exponent;
}

// A ball with a scatter distance of a thousandth, at the origin and at 1e6. At 1e6 it is also tested with another
// object at the origin, so that the scene's centre is not near the ball.
TEST(Extremes, FarFromTheOriginWalksAreTheSame) {
  const auto picture = [](double offset, bool other, uint32_t seed) {
    SceneBuilder b;
    const Matrix4d there = Matrix4d().setTranslation(Vec3d(offset, 0, 0));
    const auto ball = b.prototype(testing::sphere_mesh(1, 48, true));
    b.add(ball, b.material(medium_only(0.8f, 1e-3f)), there);
    if (other) b.add(ball, b.material(medium_only(0.8f, 0)));
    LightDescription sun;
    sun.type = LightType::distant;
    sun.intensity = 3;
    sun.light_to_world = Matrix4d(0.8, 0, -0.6, 0, 0, 1, 0, 0, 0.6, 0, 0.8, 0, 0, 0, 0, 1);
    b.add(sun);
    RenderRequest request = request_of(&b, testing::look_at({offset, 0, 5}, {offset, 0, 0}, 12), 64, 24);
    request.settings.seed = seed;
    return testing::render(request);
  };
  const auto here = picture(0, false, 0);
  expect_same(*picture(1e6, false, 1), *here, "at 1e6");
  expect_same(*picture(1e6, true, 2), *here, "at 1e6 beside another at the origin");
}

// A body much larger than the mean free path shows its albedo, however small that is, down to rounding error and below.
// A walk begins a little below the surface; if this distance did not count as a path through the medium, light would be
// lost at 1e-5.
TEST(Extremes, SmallScatterDistancesKeepTheAlbedo) {
  const auto mean = [](float distance, uint32_t seed) {
    SceneBuilder b;
    b.add(b.prototype(testing::sphere_mesh(1, 48, true)), b.material(medium_only(0.5f, distance)));
    b.add(testing::constant_dome(1, false));
    RenderRequest request = request_of(&b, testing::look_at({0, 0, 5}, {0, 0, 0}, 8), 256, 24);
    request.settings.seed = seed;
    return testing::film_mean(*testing::render(request), 1);
  };
  const MeanError lambert = mean(0, 0);
  uint32_t seed = 0;
  constexpr double kLargest = 3.2;  // of seven at the level 0.01 together (Sidak)
  for (const float distance : {1e-4f, 3e-5f, 1e-5f, 3e-6f, 1e-6f, 1e-9f, 1e-12f}) {
    const MeanError m = mean(distance, ++seed);
    const double sigma = std::hypot(m.standard_error, lambert.standard_error);
    EXPECT_LT(std::abs(m.mean - lambert.mean) / sigma, kLargest) << "d = " << distance << ": " << m.mean / lambert.mean;
    EXPECT_LT(sigma, 0.002 * lambert.mean) << "or the comparison proves nothing";
  }
}

TEST(Extremes, ParametersOfAnyValueGiveFinitePictures) {
  const float infinite = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
  for (const float albedo : {0.0f, 1e-30f, 1.0f, 2.0f, -1.0f, nan})
    for (const float distance : {0.0f, 1e-40f, 1e-20f, 1e20f, 3e38f, infinite, nan}) {
      SceneBuilder b;
      b.add(b.prototype(testing::sphere_mesh(1, 8, true)), b.material(medium_only(albedo, distance)));
      b.add(testing::constant_dome(1, false));
      RenderProgress progress;
      const MeanError m = testing::film_mean(
          *testing::render(request_of(&b, testing::look_at({0, 0, 4}, {0, 0, 0}, 10), 2, 8), &progress), 1);
      EXPECT_EQ(progress.counters.nonfinite_samples, 0u) << albedo << " " << distance;
      EXPECT_GE(m.mean, 0) << albedo << " " << distance;
      EXPECT_LE(m.mean, 1 + 4 * m.standard_error) << albedo << " " << distance;
    }
}

}  // namespace
}  // namespace alabaster
