// A light at infinity within a cone, such as the sun.
// Units, frames, pdfs and the treatment of bad values, common to all lights: light_parameters.h, light.h.
#pragma once

#include "core/light/light_parameters.h"

namespace alabaster {

/// Light from infinity along local -z, filling a cone of the angular diameter (UsdLuxDistantLight). Only the
/// transform's direction counts. A cone too narrow for float directions to resolve is a delta of the same irradiance.
class DistantLight {
 public:
  DistantLight(const LightParameters& parameters, const Vec3d& render_origin);
  std::optional<LightSample> sample(const Vec3f& p, const Vec2f& u, const Vec3f& n = Vec3f(0, 0, 0)) const;
  /// A delta is never hit.
  std::optional<LightHit> intersect(const Ray& ray, const Vec3f& n = Vec3f(0, 0, 0)) const;
  double importance(const Vec3f& p) const;
  LightExtent extent() const;
  bool is_below(const Vec3f&, const Vec3f&) const { return false; }
  std::shared_ptr<const LightImage> image() const { return nullptr; }
  bool is_delta() const { return one_minus_cos_ == 0; }

 private:
  Vec3f direction_{0, 0, 1};  // unit, towards the light
  float one_minus_cos_ = 0;   // of half the angle
  Rgb radiance_{0.0f};        // or irradiance for a delta
};

}  // namespace alabaster
