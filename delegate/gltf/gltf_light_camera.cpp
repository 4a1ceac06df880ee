#include "delegate/gltf/gltf_light_camera.h"

#include <algorithm>
#include <cmath>

namespace alabaster::hd::gltf {
namespace {

constexpr double kFilmHeight = 0.024, kFilmAspect = 1.5;  // of 35 mm film, in metres
constexpr float kNoFarPlane = 1e30f;
constexpr double kDegrees = 180 / 3.14159265358979323846;

Vec2f clipping_range(double znear, double zfar) {
  return {float(znear), zfar > znear ? float(zfar) : kNoFarPlane};
}

}  // namespace

host::CameraDescription translate_camera(const tinygltf::Camera& camera, const Matrix4d& transform) {
  host::CameraDescription description;
  description.transform = transform;
  auto& parameters = description.parameters;
  if (camera.type == "orthographic") {
    const auto& lens = camera.orthographic;
    parameters["projection"] = Token("orthographic");
    parameters["horizontalAperture"] = float(2 * std::abs(lens.xmag));
    parameters["verticalAperture"] = float(2 * std::abs(lens.ymag));
    parameters["clippingRange"] = clipping_range(lens.znear, lens.zfar);
    return description;
  }
  const auto& lens = camera.perspective;
  const double aspect = lens.aspectRatio > 0 ? lens.aspectRatio : kFilmAspect;
  parameters["projection"] = Token("perspective");
  parameters["focalLength"] = float(kFilmHeight / 2 / std::tan(lens.yfov / 2));
  parameters["horizontalAperture"] = float(kFilmHeight * aspect);
  parameters["verticalAperture"] = float(kFilmHeight);
  parameters["clippingRange"] = clipping_range(lens.znear, lens.zfar);
  return description;
}

host::LightDescription translate_light(const tinygltf::Light& light, const Matrix4d& transform) {
  host::LightDescription description;
  description.transform = transform;
  auto& parameters = description.parameters;
  parameters["color"] =
      light.color.size() == 3 ? Vec3f(float(light.color[0]), float(light.color[1]), float(light.color[2])) : Vec3f(1);
  parameters["intensity"] = float(light.intensity);
  if (light.type == "directional") {
    description.type = "distantLight";
    parameters["angle"] = 0.0f;
    return description;
  }
  description.type = "sphereLight";
  parameters["treatAsPoint"] = true;
  parameters["radius"] = 0.0f;
  if (light.type == "spot") {
    const double outer = std::clamp(light.spot.outerConeAngle, 0.0, 90 / kDegrees);
    parameters["coneInner"] = float(std::clamp(light.spot.innerConeAngle, 0.0, outer) * kDegrees);
    parameters["coneOuter"] = float(outer * kDegrees);
  }
  return description;
}

}  // namespace alabaster::hd::gltf
