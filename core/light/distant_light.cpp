#include "core/light/distant_light.h"

#include "core/math/frame.h"
#include "core/sampling/warp.h"

namespace alabaster {
namespace {

// Half angles (radians) below the spacing of float directions are taken as zero.
constexpr double kMinHalfAngle = 0x1p-23;

// UsdLux's size factor: the irradiance a unit radiance gives on a facing plane (for cones beyond a hemisphere, on both
// sides of it together).
double size_factor(double half_angle) {
  const double sin2 = std::sin(half_angle) * std::sin(half_angle);
  return kPiDouble * (half_angle <= 0.5 * kPiDouble ? sin2 : 2 - sin2);
}

}  // namespace

DistantLight::DistantLight(const LightParameters& parameters, const Vec3d& /*render_origin*/) {
  const Matrix4d& m = parameters.light_to_world;
  if (!is_valid_affine(m) || !std::isfinite(parameters.angle)) return;
  const Vec3d towards = transform_vector(Vec3d(0, 0, 1), m);
  if (!std::isfinite(dot(towards, towards)) || !(dot(towards, towards) > 0)) return;
  direction_ = to_float(towards * (1 / length(towards)));

  const double half_angle = std::clamp(static_cast<double>(parameters.angle), 0.0, 360.0) * (kPiDouble / 360);
  const Rgb emitted = emission(parameters);
  if (half_angle < kMinHalfAngle) {
    const bool is_irradiance = parameters.normalize || half_angle == 0;
    radiance_ = finite_or_black(emitted, is_irradiance ? 1 : size_factor(half_angle));
    return;
  }
  const double s = std::sin(0.5 * half_angle);
  one_minus_cos_ = static_cast<float>(2 * s * s);
  radiance_ = finite_or_black(emitted, parameters.normalize ? 1 / size_factor(half_angle) : 1);
}

std::optional<LightSample> DistantLight::sample(const Vec3f& /*p*/, const Vec2f& u, const Vec3f& /*n*/) const {
  if (is_black(radiance_)) return std::nullopt;
  LightSample s;
  s.distance = kInfinity;
  s.radiance = radiance_;
  s.delta = is_delta();
  s.wi = s.delta ? direction_ : frame_from_normal(direction_).to_world(sample_uniform_cone(u, one_minus_cos_));
  s.pdf = s.delta ? 1 : pdf_uniform_cone(one_minus_cos_);
  return s;
}

std::optional<LightHit> DistantLight::intersect(const Ray& ray, const Vec3f& /*n*/) const {
  if (is_black(radiance_) || is_delta()) return std::nullopt;
  const Vec3d direction(ray.dir);
  // |a - b|^2 = 2 (1 - cos) for unit vectors: no cancellation for narrow cones.
  const Vec3d apart = direction * (1 / length(direction)) - Vec3d(direction_);
  if (!(0.5 * dot(apart, apart) <= one_minus_cos_)) return std::nullopt;
  LightHit hit;
  hit.t = kInfinity;
  hit.radiance = radiance_;
  hit.pdf = pdf_uniform_cone(one_minus_cos_);
  return hit;
}

// pi sin^2 of the half angle, or of a right angle for wider cones.
double DistantLight::importance(const Vec3f& /*p*/) const {
  const double c = std::min(static_cast<double>(one_minus_cos_), 1.0);
  return representable_importance(radiance_, is_delta() ? 1 : kPiDouble * c * (2 - c));
}

LightExtent DistantLight::extent() const {
  return {{}, importance({}), false};
}

}  // namespace alabaster
