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

// Where the rays of a lens leave, relative to the radius of the round aperture.
std::vector<Vec2f> lens_points(uint32_t blades, float rotation) {
  CameraParameters p = at({0, 0, 0});
  p.f_stop = 2.5f;  // a radius of 10
  p.focus_distance = 500;
  p.aperture_blades = blades;
  p.aperture_rotation = rotation;
  const Camera camera(p, 300, 200, {0, 0, 0});
  std::vector<Vec2f> points;
  constexpr int kSide = 200;
  for (int i = 0; i < kSide * kSide; ++i) {
    const Vec2f u((static_cast<float>(i % kSide) + 0.5f) / kSide, (static_cast<float>(i / kSide) + 0.5f) / kSide);
    const Ray ray = camera.generate_ray({200, 60}, u);
    points.emplace_back(ray.org.x / 10, ray.org.y / 10);
    // All rays meet in the plane of focus.
    const Ray middle = Camera(at({0, 0, 0}), 300, 200, {0, 0, 0}).generate_ray({200, 60}, {0, 0});
    expect_near(ray.org + ray.dir * (-500 / ray.dir.z), middle.dir * (-500 / middle.dir.z), 0.01f);
  }
  return points;
}

// The second moment of a regular polygon of n sides and unit circumradius is (2 + cos(2 pi / n)) / 6 about both axes
// together (of a disk: 1/2).
TEST(Camera, ApertureBladesMakeAPolygonAsLargeAsTheDisk) {
  for (const uint32_t blades : {0u, 2u, 3u, 5u, 8u}) {
    const std::vector<Vec2f> points = lens_points(blades, 0);
    double farthest = 0, moment = 0, x = 0, y = 0;
    for (const Vec2f& p : points) {
      farthest = std::max(farthest, double(p.length()));
      moment += double(p.length2()) / static_cast<double>(points.size());
      x += double(p.x) / static_cast<double>(points.size()), y += double(p.y) / static_cast<double>(points.size());
    }
    const double angle = 2 * kPiDouble / blades;
    const double radius = blades < 3 ? 1 : std::sqrt(2 * kPiDouble / (blades * std::sin(angle)));
    EXPECT_NEAR(farthest, radius, 0.02 * radius) << blades;
    EXPECT_NEAR(moment, blades < 3 ? 0.5 : radius * radius * (2 + std::cos(angle)) / 6, 2e-3) << blades;
    EXPECT_NEAR(x, 0, 4e-3);
    EXPECT_NEAR(y, 0, 4e-3);
  }
}

TEST(Camera, ApertureRotationTurnsTheCorners) {
  for (const float rotation : {0.0f, 40.0f, -90.0f}) {
    Vec2f corner(0, 0);
    float farthest = 0;
    const float a = rotation * kPi / 180;
    for (const Vec2f& p : lens_points(5, rotation))
      if (const float along = p.x * std::cos(a) + p.y * std::sin(a); along > farthest) farthest = along, corner = p;
    EXPECT_NEAR(std::atan2(corner.y, corner.x), a, 0.02) << rotation;
    EXPECT_GT(corner.length(), 1.1f);
  }
}

TEST(Camera, ProjectsToWhereItsRaysComeFrom) {
  for (const bool orthographic : {false, true}) {
    CameraParameters p = at({1, 2, 3});
    p.orthographic = orthographic;
    p.horizontal_aperture_offset = 4;
    const Camera camera(p, 300, 200, {0, 0, 0});
    for (const Vec2f& film : {Vec2f(150, 100), Vec2f(10, 190), Vec2f(299, 3)}) {
      const Ray ray = camera.generate_ray(film, {0, 0});
      const auto projected = camera.project(ray.org + ray.dir * 7);
      ASSERT_TRUE(projected);
      EXPECT_NEAR(projected->x, film.x, 1e-2f);
      EXPECT_NEAR(projected->y, film.y, 1e-2f);
      const Vec3f eye = camera.to_eye(ray.org + ray.dir * 7);
      EXPECT_NEAR(-eye.z, camera.axial_depth(ray.org + ray.dir * 7), 1e-5f);
      EXPECT_FALSE(camera.project(ray.org - ray.dir)) << "behind it";
    }
  }
}

TEST(Camera, MovesThroughItsShutter) {
  CameraParameters p = at({1, 0, 0});
  EXPECT_FALSE(MovingCamera(p, 300, 200, {0, 0, 0}).moves());
  p.opens = 0.5f, p.closes = 0.75f;
  p.poses = {at({1, 0, 0}).camera_to_world, at({3, 0, 0}).camera_to_world, at({3, 8, 0}).camera_to_world};
  const MovingCamera camera(p, 300, 200, {0, 0, 0});
  EXPECT_TRUE(camera.moves());
  expect_near(camera.at(0.25f).generate_ray({150, 100}, {0, 0}).org, {2, 0, 0}, 1e-6f);
  expect_near(camera.at(0.75f).generate_ray({150, 100}, {0, 0}).org, {3, 4, 0}, 1e-6f);
  EXPECT_EQ(camera.time(0), 0.5f);
  EXPECT_EQ(camera.time(1), 0.75f);
}

/// The tangent of half the view, of a lens that is as of `p` at a share of the shutter.
float half_view(const MovingCamera& camera, float share) {
  const Vec3f d = camera.at(share).generate_ray({300, 100}, {0.5f, 0.5f}).dir;
  return d.x / -d.z;
}
/// The radius of the aperture.
float aperture(const MovingCamera& camera, float share) {
  const Camera then = camera.at(share);
  return length(then.generate_ray({150, 100}, {1, 0.5f}).org - then.generate_ray({150, 100}, {0, 0.5f}).org) / 2;
}

TEST(Camera, ItsLensMovesBetweenSamples) {
  CameraParameters p = at({0, 0, 0});
  p.shutter_open = -1, p.shutter_close = 3, p.opens = 0, p.closes = 1;
  p.f_stop = 2, p.focus_distance = 10;
  p.focal_lengths = {{-2, 0, 4}, {40, 60, 100}};
  open_lens(&p);
  EXPECT_EQ(p.focal_length, 50) << "where the shutter opens";
  const MovingCamera camera(p, 300, 200, {0, 0, 0});
  EXPECT_TRUE(camera.moves());
  EXPECT_NEAR(half_view(camera, 0), 18.0 / 50, 1e-6);
  EXPECT_NEAR(half_view(camera, 0.25f), 18.0 / 60, 1e-6);
  EXPECT_NEAR(half_view(camera, 1), 18.0 / 90, 1e-6);
  EXPECT_NEAR(aperture(camera, 0.25f), 60 / 4.0, 1e-4);
  EXPECT_NEAR(half_view(MovingCamera(p, 300, 200, {0, 0, 0}), 0.125f), 18.0 / 55, 1e-6);
}

TEST(Camera, BesideASampleWithoutALensTheEarlierOneHolds) {
  CameraParameters p = at({0, 0, 0});
  p.shutter_close = 4, p.focus_distance = 10;
  p.f_stops = {{0, 1, 2, 3}, {2, 0, 5, 10}};
  open_lens(&p);
  const MovingCamera camera(p, 300, 200, {0, 0, 0});
  EXPECT_NEAR(aperture(camera, 0.2f), 50 / 4.0, 1e-4);
  EXPECT_EQ(aperture(camera, 0.4f), 0);
  EXPECT_NEAR(aperture(camera, 0.625f), 50 / 15.0, 1e-4);
  EXPECT_NEAR(aperture(camera, 1), 50 / 20.0, 1e-4);
}

TEST(Camera, ALensThatStandsStillWithinTheShutterDoesNotMove) {
  CameraParameters p = at({0, 0, 0});
  p.shutter_open = 1, p.shutter_close = 2;
  const CameraParameters still = p;
  p.focal_lengths = {{0, 1, 2, 3}, {40, 50, 50, 60}};
  p.f_stops = {{0.5, 2.5}, {0, 8}};
  open_lens(&p);
  EXPECT_TRUE(p == still);
  EXPECT_FALSE(MovingCamera(p, 300, 200, {0, 0, 0}).moves());
}

TEST(Camera, OriginsOfAMovingLensLieInTheirBounds) {
  CameraParameters p = at({1, 2, 3});
  p.horizontal_aperture_offset = 60;  // the axis is beside the film
  p.clip_near = 4, p.shutter_close = 1;
  p.focal_lengths = {{0, 0.5, 1}, {20, 80, 30}};
  p.f_stops = {{0, 0.25, 1}, {0, 4, 1}};
  p.focus_distances = {{0, 0.7, 1}, {2, 0.5f, 20}};
  open_lens(&p);
  for (const bool turns : {false, true}) {
    if (turns) p.poses = {p.camera_to_world, Matrix4d().setAxisAngle(Vec3d(0, 1, 0), 1.0)};
    const MovingCamera camera(p, 300, 200, {0, 0, 0});
    const Bounds bounds = camera.ray_origins({0, 0}, {300, 200});
    Bounds seen;
    for (int i = 0; i <= 100; ++i)
      for (int j = 0; j < 64; ++j) {
        const Vec2f film(j & 1 ? 300 : 0, j & 2 ? 200 : 0), lens(static_cast<float>(j / 4) / 16, j & 4 ? 1 : 0.01f);
        const Vec3f org = camera.at(static_cast<float>(i) / 100).generate_ray(film, lens).org;
        seen.extend(org);
        EXPECT_TRUE(bounds.contains(org + (bounds.center() - org) * 1e-5f)) << i << " " << j;
      }
    if (!turns) {
      EXPECT_LT(length(bounds.extent()), 4 * length(seen.extent())) << "of widest and nearest at once, no more";
    }
  }
}

// Rays begin at the first plane that lets them in and end at the first that cuts them off.
TEST(Camera, ClippingPlanesCutItsRays) {
  for (const bool orthographic : {false, true}) {
    CameraParameters p;
    p.orthographic = orthographic;
    p.horizontal_aperture = p.vertical_aperture = 2;
    p.focal_length = 1;
    p.camera_to_world = Matrix4d().setAxisAngle(Vec3d(0, 1, 0), M_PI / 2) * Matrix4d().setTranslation(Vec3d(5, 0, 0));
    const Vec2f corner(0, 50), middle(50, 50);  // of 100 x 100 pixels
    const auto ray = [&](const Vec2f& film) { return Camera(p, 100, 100, {0, 0, 0}).generate_ray(film, {0, 0}); };
    const auto depths = [&](const Ray& r) {
      const Camera camera(p, 100, 100, {0, 0, 0});
      return std::pair(camera.axial_depth(r.org), camera.axial_depth(r.org + r.dir * r.tmax));
    };
    EXPECT_TRUE(std::isinf(ray(corner).tmax));
    p.clip_near = 2;
    p.clip_far = 6;
    for (const Vec2f& film : {corner, middle}) {
      const auto [begin, end] = depths(ray(film));
      EXPECT_NEAR(begin, 2, 1e-5) << orthographic;
      EXPECT_NEAR(end, 6, 1e-5) << orthographic;
    }
    p.clip_near = p.clip_far = 0;
    p.clip_planes = {{0, 0, -1, -3}};  // lets in what lies beyond 3
    EXPECT_NEAR(depths(ray(corner)).first, 3, 1e-5);
    EXPECT_TRUE(std::isinf(ray(corner).tmax));
    p.clip_planes.push_back({0, 0, 2, 8});  // and before 4; its length does not count
    EXPECT_NEAR(depths(ray(corner)).first, 3, 1e-5);
    EXPECT_NEAR(depths(ray(corner)).second, 4, 1e-5);
    p.clip_planes.push_back({0, 0, -1, -7});  // and beyond 7
    EXPECT_EQ(ray(corner).tmax, 0);
    p.clip_planes = {{1, 0, 0, -0.25f}};  // the right side
    EXPECT_EQ(ray(corner).tmax, 0);
    if (orthographic) {
      EXPECT_EQ(ray(middle).tmax, 0) << "runs along the plane, on the side that is cut off";
    }
    p.clip_planes = {{1, 0, 0, 0.25f}};
    EXPECT_TRUE(std::isinf(ray(middle).tmax));
  }
}

}  // namespace
}  // namespace alabaster
