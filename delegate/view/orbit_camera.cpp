#include "delegate/view/orbit_camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "delegate/support/lookup.h"
#include "delegate/support/window_policy.h"

namespace alabaster::view {
namespace {

using hd::Matrix4d;
using hd::Vec3d;
using hd::support::number_in;
using hd::support::text_in;

constexpr double kHighestElevation = 89.5 * std::numbers::pi / 180;

Vec3d axis(const Matrix4d& m, int row) {
  return {m[row][0], m[row][1], m[row][2]};
}

Matrix4d rotated_about(const Matrix4d& camera, const Vec3d& pivot, const Vec3d& around, double angle) {
  Matrix4d turn;
  turn.setAxisAngle(around, angle);
  return camera * Matrix4d().setTranslation(-pivot) * turn * Matrix4d().setTranslation(pivot);
}

bool is_orthographic(const hd::CameraDescription& camera) {
  return text_in(camera.parameters, "projection") == "orthographic";
}

}  // namespace

Matrix4d orbited(const Matrix4d& camera, const Vec3d& pivot, double yaw, double pitch, const Vec3d& up) {
  const Matrix4d turned = rotated_about(camera, pivot, up, yaw);
  const Vec3d right = axis(turned, 0).normalized(), back = axis(turned, 2).normalized();
  const double elevation = std::asin(std::clamp(back.dot(up), -1.0, 1.0));
  const double most = std::max(kHighestElevation, std::abs(elevation));
  const double wanted = std::clamp(elevation + pitch, -most, most);
  return rotated_about(turned, pivot, right, elevation - wanted);
}

Matrix4d panned(const Matrix4d& camera, double right, double up) {
  return camera * Matrix4d().setTranslation(axis(camera, 0).normalized() * right + axis(camera, 1).normalized() * up);
}

Matrix4d dollied(const Matrix4d& camera, const Vec3d& pivot, double factor) {
  return camera * Matrix4d().setTranslation((camera.translation() - pivot) * (factor - 1));
}

Sight sight_of(const hd::CameraDescription& camera, const hd::Framing& framing, hd::WindowPolicy policy) {
  Sight sight;
  sight.orthographic = is_orthographic(camera);
  // The contract's defaults, as schemas/camera.json has them.
  const double focal = sight.orthographic ? 1 : number_in(camera.parameters, "focalLength", 50);
  const hd::Vec2f size = framing.displayMax - framing.displayMin;
  const double aspect = double(size.x) / double(size.y) * double(framing.pixelAspectRatio);
  const hd::support::CameraWindow seen =
      hd::support::conform_window({number_in(camera.parameters, "horizontalAperture", 36) / focal,
                                   number_in(camera.parameters, "verticalAperture", 24) / focal},
                                  aspect, policy);
  sight.width = seen.width, sight.height = seen.height;
  sight.right = number_in(camera.parameters, "horizontalApertureOffset", 0) / focal;
  sight.up = number_in(camera.parameters, "verticalApertureOffset", 0) / focal;
  return sight;
}

Vec3d point_at(const Matrix4d& camera, const Sight& sight, double x, double y, double depth) {
  const double scale = sight.orthographic ? 1 : depth;
  const Vec3d local(((x - 0.5) * sight.width + sight.right) * scale, ((0.5 - y) * sight.height + sight.up) * scale,
                    -depth);
  Vec3d world;
  camera.multVecMatrix(local, world);
  return world;
}

std::optional<hd::Vec2d> place_of(const Matrix4d& camera, const Sight& sight, const Vec3d& point) {
  Vec3d local;
  camera.inverse().multVecMatrix(point, local);
  if (!(local.z < 0)) return std::nullopt;
  const double scale = sight.orthographic ? 1 : -local.z;
  return hd::Vec2d((local.x / scale - sight.right) / sight.width + 0.5,
                   0.5 - (local.y / scale - sight.up) / sight.height);
}

void zoom(hd::CameraDescription* camera, const Vec3d& pivot, double factor) {
  if (!is_orthographic(*camera)) {
    camera->transform = dollied(camera->transform, pivot, factor);
    return;
  }
  // The pivot stays in its place of the picture.
  Vec3d local;
  camera->transform.inverse().multVecMatrix(pivot, local);
  camera->transform =
      panned(camera->transform, (1 - factor) * (local.x - number_in(camera->parameters, "horizontalApertureOffset", 0)),
             (1 - factor) * (local.y - number_in(camera->parameters, "verticalApertureOffset", 0)));
  camera->parameters["horizontalAperture"] = float(number_in(camera->parameters, "horizontalAperture", 36) * factor);
  camera->parameters["verticalAperture"] = float(number_in(camera->parameters, "verticalAperture", 24) * factor);
}

}  // namespace alabaster::view
