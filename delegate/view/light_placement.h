// Where lights stand and what they shine at. World space; a light shines along its -z.
#pragma once

#include "delegate/host/retained_scene_delegate.h"

namespace alabaster::view {

/// A point of what the picture shows. The normal is that of its shading, of length 1.
struct SurfacePoint {
  hd::Vec3d point{0, 0, 0}, normal{0, 0, 1};
};

/// What the mouse does to a light.
enum class LightTool { none, move, aim, highlight };
/// A dome has neither a place nor a direction, and a distant light has no place.
bool can_use(LightTool tool, const std::string& light_type);

/// Turns a light towards `target`, with its x axis level. It keeps its place and size.
hd::Matrix4d aimed(const hd::Matrix4d& light, const hd::Vec3d& target, const hd::Vec3d& up);

/// Puts a light where the surface mirrors it to an eye in direction `to_eye` from the point, and aims it at the point.
hd::Matrix4d mirrored(const hd::Matrix4d& light, const SurfacePoint& surface, const hd::Vec3d& to_eye, double distance,
                      const hd::Vec3d& up);

/// The types of lights that add_light of a session takes, and the window offers.
constexpr const char* kNewLights[] = {"rectLight", "diskLight", "sphereLight", "distantLight", "domeLight"};

/// A light of that type for what `camera` sees at `target`: from its left and above, as far away as the camera. A white
/// surface that faces it gets a radiance of about 1, less from a dome.
hd::host::LightDescription new_light(const std::string& type, const hd::Matrix4d& camera, const hd::Vec3d& target,
                                     const hd::Vec3d& up);

}  // namespace alabaster::view
