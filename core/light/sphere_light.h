// A sphere or a point, with an optional spot.
// Units, frames, pdfs and the treatment of bad values, common to all lights: light_description.h, light.h.
#pragma once

#include "core/light/light_description.h"

namespace alabaster {

/// Attenuation of a spot about an axis, as KHR_lights_punctual defines it: 1 inside the inner cone, 0 outside the outer
/// one, between them the square of the linear ramp in cos(angle). Kept as 1 - cos, which does not cancel for narrow
/// cones.
class SpotCone {
 public:
  SpotCone() = default;
  /// Half angles in degrees, clamped to [0, 180] (not finite: 180); the inner is at most the outer.
  SpotCone(float inner, float outer, const Vec3d& axis);
  /// `direction`: unit, away from the light.
  float attenuation(const Vec3d& direction) const;
  /// The largest attenuation among the directions within an angle (below 90 degrees) of `direction`; it errs by
  /// rounding only upwards, so that 0 is a proof.
  float largest_attenuation(const Vec3d& direction, double sin_half_angle) const;
  /// Mean attenuation over the sphere of directions.
  double mean() const;

 private:
  float attenuation_at(double one_minus_cos) const;

  Vec3d axis_{0, 0, -1};
  double inner_ = 2, outer_ = 2;  // 1 - cos
};

/// A sphere that emits from every point (UsdLuxSphereLight), or a point. From outside, directions are drawn uniformly
/// over the cone it fills; from inside it is seen in every direction, and they are drawn uniformly over the sphere.
/// Spot shaping scales the radiance by the emitted direction.
class SphereLight {
 public:
  SphereLight(const LightDescription& description, const Vec3d& render_origin);
  std::optional<LightSample> sample(const Vec3f& p, const Vec2f& u) const;
  /// A point is never hit.
  std::optional<LightHit> intersect(const Ray& ray) const;
  /// 0 only where no part of the sphere sends light.
  double importance(const Vec3f& p) const;
  LightExtent extent() const;
  /// True only if every direction from p to the light lies below the plane through p with unit normal n.
  bool is_below(const Vec3f& p, const Vec3f& n) const;
  bool is_delta() const { return radius_ == 0; }

 private:
  std::optional<LightSample> sample_point(const Vec3d& to_center) const;

  Vec3d center_{0, 0, 0};
  SpotCone cone_;
  double radius_ = 0;
  Rgb radiance_{0.0f};  // or radiant intensity for a point
};

}  // namespace alabaster
