// How a camera follows a mouse. World space; no horizon is tilted that was level.
#pragma once

#include <optional>

#include "delegate/api/scene_types.h"

namespace alabaster::view {

/// Rotates the camera about `pivot`: by `yaw` around the axis that points up, then by `pitch` around its own x axis,
/// radians. Positive ones move the camera to the right and upwards. It ends short of the poles.
hd::Matrix4d orbited(const hd::Matrix4d& camera, const hd::Vec3d& pivot, double yaw, double pitch,
                     const hd::Vec3d& up = {0, 1, 0});

/// Moves the camera along its own x and y axes, in scene units.
hd::Matrix4d panned(const hd::Matrix4d& camera, double right, double up);

/// Moves the camera so that its distance to `pivot` is multiplied by `factor`, above 0.
hd::Matrix4d dollied(const hd::Matrix4d& camera, const hd::Vec3d& pivot, double factor);

/// The part of the plane at distance 1 that a perspective camera sees, or of any plane for an orthographic one.
struct Sight {
  bool orthographic = false;
  double width = 0, height = 0;  // scene units
  double right = 0, up = 0;      // of its middle from the view axis, by a shift of the lens
  bool operator==(const Sight&) const = default;
};
Sight sight_of(const hd::CameraDescription& camera, const hd::Framing& framing, hd::WindowPolicy policy);

/// The point that place (x, y) of the picture, from 0 to 1 with y down, shows at `depth` along the view axis.
hd::Vec3d point_at(const hd::Matrix4d& camera, const Sight& sight, double x, double y, double depth);

/// The place of the picture that shows a point of the world. Empty: it lies behind the camera.
std::optional<hd::Vec2d> place_of(const hd::Matrix4d& camera, const Sight& sight, const hd::Vec3d& point);

/// Zooms: a perspective camera moves towards `pivot`, an orthographic one gets a film of `factor` times the size.
void zoom(hd::CameraDescription* camera, const hd::Vec3d& pivot, double factor);

}  // namespace alabaster::view
