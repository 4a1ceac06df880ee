// How the radiance of a light depends on the direction in which it leaves.
#pragma once

#include <memory>

#include "core/light/ies_profile.h"
#include "core/light/light_parameters.h"

namespace alabaster {

/// Attenuation about an axis: 1 inside the inner cone, 0 outside the outer one. Kept as 1 - cos, which does not cancel
/// for narrow cones.
class SpotCone {
 public:
  /// How the light falls between the cones.
  enum class Falloff {
    square_of_cosine,  // KHR_lights_punctual: the square of the linear ramp in cos(angle)
    smooth_in_angle    // UsdLuxShapingAPI: 1 - smoothstep of the angle
  };
  SpotCone() = default;
  /// Half angles in degrees, clamped to [0, 180] (not finite: 180); the inner is at most the outer.
  SpotCone(float inner, float outer, Falloff falloff);
  /// The outer half angle in radians.
  double widest_angle() const;
  /// `one_minus_cos`: of the angle to the axis.
  float attenuation(double one_minus_cos) const;

 private:
  double inner_ = 2, outer_ = 2;  // 1 - cos
  Falloff falloff_ = Falloff::square_of_cosine;
};

/// Spot cone, focus and IES profile (UsdLuxShapingAPI). Immutable; a light without shaping has none.
class LightShaping {
 public:
  /// Null if the parameters shape nothing. Their transform is valid and affine.
  static std::shared_ptr<const LightShaping> make(const LightParameters& parameters);
  /// Multiplies the radiance. `direction`: unit, away from the light.
  Rgb factor(const Vec3d& direction) const;
  /// At least the luminance of the factor, and 0 only where the factor is black, in all directions within an angle of
  /// `direction` (any direction if the sine is 1 or more).
  double largest(const Vec3d& direction, double sin_half_angle) const;
  const Vec3d& axis() const { return axis_; }
  /// Half angle of the cone about the axis outside which all is dark.
  double widest_angle() const { return cone_.widest_angle(); }
  /// Mean of the factor over the sphere of directions, as luminance; of a profile beside a cone or focus, an estimate.
  double mean() const { return mean_; }

 private:
  LightShaping(const LightParameters& parameters, const Vec3d& axis);
  Rgb factor_at(double one_minus_cos) const;
  /// The vertical angle in the profile of one in the light, in degrees.
  double profile_angle(double degrees) const;

  Vec3d x_{1, 0, 0}, y_{0, 1, 0}, axis_;  // the light's x, y and -z: orthonormal, perhaps left-handed
  SpotCone cone_;
  double focus_;
  Rgb focus_tint_;
  std::shared_ptr<const IesProfile> profile_;
  double profile_scale_ = 1, angle_scale_ = 0;
  double mean_ = 0;
};

/// The extent of a light that would emit everywhere, with its shaping.
inline LightExtent shaped(LightExtent extent, const std::shared_ptr<const LightShaping>& shaping) {
  if (!shaping) return extent;
  extent.axis = shaping->axis();
  extent.normals_angle = shaping->widest_angle();
  extent.emission_angle = 0;
  return extent;
}

/// Radiance that leaves in this direction.
inline Rgb shaped(const Rgb& radiance, const std::shared_ptr<const LightShaping>& shaping, const Vec3d& direction) {
  return shaping ? radiance * shaping->factor(direction) : radiance;
}

}  // namespace alabaster
