#include "delegate/view/light_placement.h"

#include <cmath>

#include "delegate/view/orbit_camera.h"

namespace alabaster::view {

using hd::Matrix4d;
using hd::Vec3d;

bool can_use(LightTool tool, const std::string& light_type) {
  if (tool == LightTool::none || light_type == "distantLight")
    return tool == LightTool::none || tool == LightTool::highlight;
  return light_type != "domeLight";
}

Matrix4d aimed(const Matrix4d& light, const Vec3d& target, const Vec3d& up) {
  Vec3d z = light.translation() - target;
  if (!(z.length() > 0)) return light;
  z.normalize();
  Vec3d x = up.cross(z);
  if (!(x.length() > 1e-6)) x = Vec3d(up.y, up.z, up.x).cross(z);  // it shines straight up or down
  x.normalize();
  Vec3d axes[3] = {x, z.cross(x), z};
  if (light.determinant() < 0) axes[0] = -axes[0];  // an image on it stays mirrored
  Matrix4d m = light;
  for (int row = 0; row < 3; ++row) {
    const double size = Vec3d(light[row][0], light[row][1], light[row][2]).length();
    for (int i = 0; i < 3; ++i) m[row][i] = axes[row][i] * size;
  }
  return m;
}

Matrix4d mirrored(const Matrix4d& light, const SurfacePoint& surface, const Vec3d& to_eye, double distance,
                  const Vec3d& up) {
  const double cosine = surface.normal.dot(to_eye);
  const Vec3d place = surface.point + (surface.normal * (2 * cosine) - to_eye) * distance;
  Matrix4d m = light;
  for (int i = 0; i < 3; ++i) m[3][i] = place[i];
  return aimed(m, surface.point, up);
}

hd::host::LightDescription new_light(const std::string& type, const Matrix4d& camera, const Vec3d& target,
                                     const Vec3d& up) {
  constexpr double kLeft = 0.8, kAbove = 0.6;  // radians
  hd::host::LightDescription light;
  light.type = type;
  const auto distance = float((camera.translation() - target).length());
  if (type == "rectLight")
    light.parameters = {{"intensity", 20.0f}, {"width", 0.4f * distance}, {"height", 0.4f * distance}};
  else if (type == "diskLight")
    light.parameters = {{"intensity", 20.0f}, {"radius", 0.22f * distance}};
  else if (type == "sphereLight")
    light.parameters = {{"intensity", 100.0f}, {"radius", 0.1f * distance}};
  else if (type == "distantLight")
    light.parameters = {{"intensity", 3.0f}, {"normalize", true}};
  else
    light.parameters = {{"intensity", 0.3f}};
  if (type == "domeLight") return light;
  light.transform.setTranslation(orbited(camera, target, -kLeft, kAbove, up).translation());
  light.transform = aimed(light.transform, target, up);
  return light;
}

}  // namespace alabaster::view
