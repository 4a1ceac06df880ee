#include "core/light/moving_light.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/math/motion.h"

namespace alabaster {
namespace {

// No point of the light is farther from its centre than this times the longest row of its transform. A sphere's and a
// cylinder's radius is a mean of stretches, each at most that.
double reach(const LightParameters& d) {
  const double r = 2.0 * std::abs(d.radius);
  switch (d.type) {
    case LightType::rect:
      return 0.5 * (std::abs(static_cast<double>(d.width)) + std::abs(static_cast<double>(d.height)));
    case LightType::cylinder:
      return r + 0.5 * std::abs(static_cast<double>(d.length));
    case LightType::sphere:
      return d.treat_as_point ? 0 : r;
    default:
      return r;
  }
}

// Centres move in straight lines, and rows are longest at a pose.
BoundsDouble box_over(const LightParameters& d, const std::vector<Matrix4d>& poses, const Vec3d& render_origin) {
  double longest = 0;
  for (const Matrix4d& m : poses)
    for (const Vec3d& axis : {Vec3d(1, 0, 0), Vec3d(0, 1, 0), Vec3d(0, 0, 1)})
      longest = std::max(longest, length(transform_vector(axis, m)));
  BoundsDouble box;
  for (const Matrix4d& m : poses) {
    const Vec3d center = transform_point(Vec3d(0, 0, 0), m) - render_origin, half(reach(d) * longest);
    box.extend(center - half), box.extend(center + half);
  }
  return box;
}

}  // namespace

StillLight place_light(const LightParameters& d, const Vec3d& render_origin, const LightImages& images) {
  switch (d.type) {
    case LightType::rect:
    case LightType::disk:
      return RectDiskLight(d, render_origin, images);
    case LightType::cylinder:
      return CylinderLight(d, render_origin);
    case LightType::sphere:
      return SphereLight(d, render_origin);
    case LightType::distant:
      return DistantLight(d, render_origin);
    case LightType::dome:
      break;
  }
  return DomeLight(d, render_origin, images);
}

MovingLight::MovingLight(const LightParameters& parameters, const Vec3d& render_origin, const LightImages& images) {
  auto made = std::make_shared<OverShutter>(OverShutter{parameters, {}, render_origin, {}, {}});
  made->poses.swap(made->parameters.poses);
  made->parameters.name.clear();
  LightImages one = images;
  for (const Matrix4d& pose : made->poses) {
    made->parameters.light_to_world = pose;
    std::visit(
        [&](const auto& light) {
          if constexpr (requires { one.same = light.image(); }) one.same = light.image();
          const LightExtent then = light.extent();
          made->extent.power = std::max(made->extent.power, then.power), made->extent.finite = then.finite;
        },
        place_light(made->parameters, render_origin, one));
  }
  made->image = one.same;
  if (made->extent.finite) made->extent.box = box_over(parameters, parameters.poses, render_origin);
  over_shutter_ = std::move(made);
}

StillLight MovingLight::at(float time) const {
  const auto& [parameters, poses, render_origin, image, extent] = *over_shutter_;
  const PoseTime then(std::clamp(time, 0.0f, 1.0f), poses.size());
  LightParameters placed = parameters;
  const double share = then.fraction;
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column)
      placed.light_to_world[row][column] =
          poses[then.first][row][column] * (1 - share) + poses[then.first + 1][row][column] * share;
  return place_light(placed, render_origin, {.same = image});
}

std::optional<LightSample> MovingLight::sample(const Vec3f& p, const Vec2f& u, const Vec3f& n, float time) const {
  return std::visit([&](const auto& light) { return light.sample(p, u, n); }, at(time));
}

std::optional<LightHit> MovingLight::intersect(const Ray& ray, const Vec3f& n) const {
  return std::visit([&](const auto& light) { return light.intersect(ray, n); }, at(ray.time));
}

double MovingLight::importance(const Vec3f& p) const {
  const LightExtent& extent = over_shutter_->extent;
  if (!extent.finite || !(extent.power > 0)) return extent.power;
  const Vec3d d = extent.box.center() - Vec3d(p), half = extent.box.extent() * 0.5;
  const double far2 = dot(d, d) + dot(half, half);
  return far2 > 0 ? std::clamp(extent.power / far2, 0x1p-1000, 0x1p+960) : 0x1p+960;
}

}  // namespace alabaster
