#include "delegate/rendering/camera_matrices.h"

namespace alabaster::hd::rendering {
namespace {

Vec3d row_of(const Matrix4d& m, int row) {
  return {m[row][0], m[row][1], m[row][2]};
}

}  // namespace

CameraMatrices camera_matrices(const CameraParameters& camera) {
  CameraMatrices matrices;
  const Matrix4d& from = camera.camera_to_world;
  const Vec3d origin = row_of(from, 3);
  const Vec3d axes[] = {row_of(from, 0).normalized(), row_of(from, 1).normalized(), -row_of(from, 2).normalized()};
  for (int column = 0; column < 3; ++column) {
    for (int row = 0; row < 3; ++row) matrices.world_to_camera[row][column] = axes[column][row];
    matrices.world_to_camera[3][column] = -(origin ^ axes[column]);
  }
  const double focal = camera.orthographic ? 1 : double(camera.focal_length);
  const double width = double(camera.horizontal_aperture) / focal, height = double(camera.vertical_aperture) / focal;
  const double x = double(camera.horizontal_aperture_offset) / focal;
  const double y = double(camera.vertical_aperture_offset) / focal;
  const double near = camera.clip_near > 0 ? double(camera.clip_near) : camera.orthographic ? 0 : 1;
  const double far = double(camera.clip_far);
  const bool ends = far > near;
  Matrix4d projection;
  projection[0][0] = 2 / width, projection[1][1] = 2 / height;
  const int shifted = camera.orthographic ? 3 : 2;  // by a constant, or by the distance that divides
  projection[shifted][0] = -2 * x / width, projection[shifted][1] = -2 * y / height;
  if (camera.orthographic) {
    const double depth = ends ? far - near : 1;
    projection[2][2] = 1 / depth, projection[3][2] = -near / depth;
  } else {
    projection[2][2] = ends ? far / (far - near) : 1;
    projection[3][2] = -near * projection[2][2];
    projection[2][3] = 1, projection[3][3] = 0;
  }
  matrices.world_to_ndc = matrices.world_to_camera * projection;
  return matrices;
}

}  // namespace alabaster::hd::rendering
