#include "delegate/rendering/camera_matrices.h"

#include <gtest/gtest.h>

namespace alabaster::hd::rendering {
namespace {

CameraParameters turned_camera() {
  CameraParameters camera;
  camera.camera_to_world.rotate(Vec3d(0.3, -1.1, 0.5));
  camera.camera_to_world[3][0] = 3, camera.camera_to_world[3][1] = -2, camera.camera_to_world[3][2] = 7;
  camera.focal_length = 40, camera.horizontal_aperture = 30, camera.vertical_aperture = 20;
  camera.horizontal_aperture_offset = 4, camera.vertical_aperture_offset = -3;
  camera.clip_near = 0.5f, camera.clip_far = 80;
  return camera;
}

struct Projected {
  Vec3d ndc;
  double w;
};
Projected project(const Vec3d& p, const Matrix4d& m) {
  double to[4];
  for (int i = 0; i < 4; ++i) to[i] = p.x * m[0][i] + p.y * m[1][i] + p.z * m[2][i] + m[3][i];
  return {{to[0] / to[3], to[1] / to[3], to[2] / to[3]}, to[3]};
}

// Rows of pixels run down, and y of normalized device coordinates up.
TEST(CameraMatrices, ProjectAsTheCameraDoes) {
  constexpr int kWidth = 300, kHeight = 200;
  for (const bool orthographic : {false, true}) {
    CameraParameters parameters = turned_camera();
    parameters.orthographic = orthographic;
    const Vec3d origin(1, 2, 3);
    const Camera camera(parameters, kWidth, kHeight, origin);
    const CameraMatrices matrices = camera_matrices(parameters);
    for (const auto& film : {Vec2f(10, 20), Vec2f(250, 20), Vec2f(140, 190)}) {
      const Ray ray = camera.generate_ray(film, {0.5f, 0.5f});
      for (const double t : {2.0, 30.0}) {
        const Vec3d p = origin + Vec3d(ray.org) + Vec3d(ray.dir) * t;
        const Projected at = project(p, matrices.world_to_ndc);
        EXPECT_NEAR((at.ndc.x + 1) / 2 * kWidth, double(film.x), 2e-3);
        EXPECT_NEAR((1 - at.ndc.y) / 2 * kHeight, double(film.y), 2e-3);
        const double depth = project(p, matrices.world_to_camera).ndc.z;
        EXPECT_NEAR(depth, double(camera.axial_depth(Vec3f(p - origin))), 1e-4 * depth);
        EXPECT_GT(depth, 0) << "z runs into the picture";
        EXPECT_NEAR(at.ndc.z, double(camera.clip_depth(static_cast<float>(depth))), orthographic ? 1 : 1e-5);
        EXPECT_NEAR(at.w, orthographic ? 1 : depth, 1e-9 * depth);
      }
    }
  }
}

TEST(CameraMatrices, CanBeInvertedWithoutClippingPlanes) {
  for (const bool orthographic : {false, true}) {
    CameraParameters camera = turned_camera();
    camera.clip_near = camera.clip_far = 0, camera.orthographic = orthographic;
    const Matrix4d& m = camera_matrices(camera).world_to_ndc;
    const Matrix4d both = m * m.inverse();
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) EXPECT_NEAR(both[i][j], i == j ? 1 : 0, 1e-9);
  }
}

TEST(CameraMatrices, KeepLengthsOfAScaledCamera) {
  CameraParameters camera = turned_camera(), scaled = camera;
  for (int row = 0; row < 3; ++row)
    for (int i = 0; i < 3; ++i) scaled.camera_to_world[row][i] *= 5;
  const Matrix4d a = camera_matrices(camera).world_to_camera, b = camera_matrices(scaled).world_to_camera;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) EXPECT_NEAR(a[i][j], b[i][j], 1e-12);
}

}  // namespace
}  // namespace alabaster::hd::rendering
