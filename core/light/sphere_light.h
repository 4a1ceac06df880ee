// A sphere or a point.
// Units, frames, pdfs and the treatment of bad values, common to all lights: light_parameters.h, light.h.
#pragma once

#include "core/light/light_shaping.h"

namespace alabaster {

/// A sphere that emits from every point (UsdLuxSphereLight), or a point. From outside, directions are drawn uniformly
/// over the cone it fills; from inside it is seen in every direction, and they are drawn uniformly over the sphere.
class SphereLight {
 public:
  SphereLight(const LightParameters& parameters, const Vec3d& render_origin);
  std::optional<LightSample> sample(const Vec3f& p, const Vec2f& u, const Vec3f& n = Vec3f(0, 0, 0)) const;
  /// A point is never hit.
  std::optional<LightHit> intersect(const Ray& ray, const Vec3f& n = Vec3f(0, 0, 0)) const;
  /// 0 only where no part of the sphere sends light.
  double importance(const Vec3f& p) const;
  LightExtent extent() const;
  std::shared_ptr<const LightImage> image() const { return nullptr; }
  /// True only if every direction from p to the light lies below the plane through p with unit normal n.
  bool is_below(const Vec3f& p, const Vec3f& n) const;
  bool is_delta() const { return radius_ == 0; }

 private:
  std::optional<LightSample> sample_point(const Vec3d& to_center) const;

  Vec3d center_{0, 0, 0};
  double radius_ = 0;
  Rgb radiance_{0.0f};  // or radiant intensity for a point
  std::shared_ptr<const LightShaping> shaping_;
};

}  // namespace alabaster
