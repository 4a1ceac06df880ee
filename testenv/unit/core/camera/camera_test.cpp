#include "core/camera/camera.h"

#include <gtest/gtest.h>

namespace alabaster {
namespace {

CameraParameters at(const Vec3d& eye) {
  CameraParameters p;
  p.camera_to_world.setTranslation(eye);
  p.focal_length = 50;
  p.horizontal_aperture = 36;
  p.vertical_aperture = 24;
  return p;
}

void expect_near(const Vec3f& a, const Vec3f& b, float tolerance) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
}

TEST(Camera, CornersSpanTheApertures) {
  const Camera camera(at({1, 2, 3}), 300, 200, {1, 2, 2});
  const Ray top_left = camera.generate_ray({0, 0}, {0, 0});
  expect_near(top_left.org, {0, 0, 1}, 0);  // in render space
  expect_near(top_left.dir, normalize(Vec3f(-0.36f, 0.24f, -1)), 1e-6f);
  expect_near(camera.generate_ray({300, 200}, {0, 0}).dir, normalize(Vec3f(0.36f, -0.24f, -1)), 1e-6f);
  expect_near(camera.generate_ray({150, 100}, {0, 0}).dir, {0, 0, -1}, 1e-6f);
}

TEST(Camera, ApertureOffsetShiftsTheFilm) {
  CameraParameters p = at({0, 0, 0});
  p.horizontal_aperture_offset = 18;
  expect_near(Camera(p, 300, 200, {0, 0, 0}).generate_ray({0, 100}, {0, 0}).dir, {0, 0, -1}, 1e-6f);
}

// The spread of the rays through neighbouring pixels, in the narrower direction.
TEST(Camera, PixelConeIsTheDistanceOfNeighbouringRays) {
  CameraParameters p = at({0, 0, 0});
  for (const Vec2f& film : {Vec2f(150, 100), Vec2f(0, 100), Vec2f(20, 7)}) {
    const Camera camera(p, 300, 200, {0, 0, 0});
    const Vec3f d = camera.generate_ray(film, {0, 0}).dir;
    const float x = length(camera.generate_ray(film + Vec2f(1, 0), {0, 0}).dir - d);
    const float y = length(camera.generate_ray(film + Vec2f(0, 1), {0, 0}).dir - d);
    const PixelCone cone = camera.pixel_cone(d);
    EXPECT_EQ(cone.width, 0);
    EXPECT_LE(cone.spread, 1.01f * std::min(x, y));
    EXPECT_GE(cone.spread, 0.8f * std::min(x, y));
  }
  p.orthographic = true;
  const PixelCone cone = Camera(p, 300, 100, {0, 0, 0}).pixel_cone({0, 0, -1});
  EXPECT_FLOAT_EQ(cone.width, 0.12f);
  EXPECT_EQ(cone.spread, 0);
}

TEST(Camera, LensRaysMeetInThePlaneOfFocus) {
  CameraParameters p = at({0, 0, 0});
  p.f_stop = 2;
  p.focus_distance = 400;
  const Camera camera(p, 300, 200, {0, 0, 0});
  const auto focus_point = [&](const Vec2f& lens) {
    const Ray ray = camera.generate_ray({40, 170}, lens);
    return ray.org + ray.dir * ((-400 - ray.org.z) / ray.dir.z);
  };
  const Vec3f first = focus_point({0.5f, 0.5f});
  for (const Vec2f& lens : {Vec2f(0.1f, 0.2f), Vec2f(0.9f, 0.3f), Vec2f(0.999f, 0.999f)}) {
    expect_near(focus_point(lens), first, 1e-3f);
    const Ray ray = camera.generate_ray({40, 170}, lens);
    EXPECT_LE(std::hypot(ray.org.x, ray.org.y), 50 / (2 * 2.0f) * 1.0001f);  // lens radius = focal length / (2 f-stop)
  }
}

TEST(Camera, OrthographicRaysAreParallel) {
  CameraParameters p = at({0, 0, 5});
  p.orthographic = true;
  p.horizontal_aperture = p.vertical_aperture = 4;
  const Camera camera(p, 100, 100, {0, 0, 0});
  const Ray ray = camera.generate_ray({0, 0}, {0, 0});
  expect_near(ray.org, {-2, 2, 5}, 1e-6f);
  expect_near(ray.dir, {0, 0, -1}, 0);
}

TEST(Camera, DepthRunsFromNearToFar) {
  CameraParameters p = at({0, 0, 0});
  p.clip_near = 0.1f;
  p.clip_far = 100;
  const Camera camera(p, 10, 10, {0, 0, 0});
  EXPECT_NEAR(camera.clip_depth(0.1f), 0, 1e-6);
  EXPECT_NEAR(camera.clip_depth(100), 1, 1e-6);
  EXPECT_NEAR(camera.axial_depth({3, 4, -7}), 7, 1e-6);
  const Ray ray = camera.generate_ray({0, 0}, {0, 0});
  EXPECT_NEAR(camera.axial_depth(ray.org), 0.1, 1e-6) << "rays start at the near plane";
}

TEST(Camera, ScaleInTheTransformIsIgnored) {
  CameraParameters p = at({0, 0, 0});
  p.camera_to_world.setScale(Vec3d(3, 3, 3));
  expect_near(Camera(p, 300, 200, {0, 0, 0}).generate_ray({0, 0}, {0, 0}).dir, normalize(Vec3f(-0.36f, 0.24f, -1)),
              1e-6f);
}

}  // namespace
}  // namespace alabaster
