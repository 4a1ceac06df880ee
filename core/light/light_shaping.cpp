#include "core/light/light_shaping.h"

namespace alabaster {
namespace {

double one_minus_cos_degrees(float angle) {
  const double clamped = std::isfinite(angle) ? std::clamp(static_cast<double>(angle), 0.0, 180.0) : 180.0;
  const double s = std::sin(clamped * (kPiDouble / 360));
  return 2 * s * s;
}

constexpr double kDegrees = 180 / kPiDouble;

double angle_of(double one_minus_cos) {
  return 2 * std::asin(std::min(1.0, std::sqrt(0.5 * one_minus_cos)));
}

SpotCone make_cone(const LightParameters& d) {
  const float softness = std::clamp(d.cone_softness, 0.0f, 1.0f);
  if (d.cone_angle < 180 || softness > 0)
    return SpotCone(d.cone_angle * (1 - softness), d.cone_angle, SpotCone::Falloff::smooth_in_angle);
  return SpotCone(d.cone_inner, d.cone_outer, SpotCone::Falloff::square_of_cosine);
}

}  // namespace

SpotCone::SpotCone(float inner, float outer, Falloff falloff)
    : inner_(one_minus_cos_degrees(inner)), outer_(one_minus_cos_degrees(outer)), falloff_(falloff) {
  inner_ = std::min(inner_, outer_);
}

float SpotCone::attenuation(double one_minus_cos) const {
  if (one_minus_cos <= inner_) return outer_ > 0 ? 1.0f : 0.0f;
  if (one_minus_cos >= outer_) return 0;
  if (falloff_ == Falloff::smooth_in_angle) {
    const double inner = angle_of(inner_), ramp = (angle_of(one_minus_cos) - inner) / (angle_of(outer_) - inner);
    return static_cast<float>((1 - ramp) * (1 - ramp) * (1 + 2 * ramp));
  }
  const double ramp = (outer_ - one_minus_cos) / (outer_ - inner_);
  return static_cast<float>(ramp * ramp);
}

double SpotCone::widest_angle() const {
  return angle_of(outer_);
}

std::shared_ptr<const LightShaping> LightShaping::make(const LightParameters& d) {
  const bool cone = !(d.cone_angle >= 180) || d.cone_softness > 0 || !(std::min(d.cone_inner, d.cone_outer) >= 180);
  if (!cone && !(d.focus > 0) && !d.ies) return nullptr;
  const Vec3d axis = transform_vector(Vec3d(0, 0, -1), d.light_to_world);
  return std::shared_ptr<const LightShaping>(new LightShaping(d, axis * (1 / length(axis))));
}

LightShaping::LightShaping(const LightParameters& d, const Vec3d& axis)
    : axis_(axis),
      cone_(make_cone(d)),
      focus_(std::isfinite(d.focus) ? std::max(d.focus, 0.0f) : 0.0f),
      focus_tint_(finite_or_black(d.focus_tint, 1)),
      profile_(d.ies),
      angle_scale_(std::isfinite(d.ies_angle_scale) ? d.ies_angle_scale : 0) {
  const Vec3d x = transform_vector(Vec3d(1, 0, 0), d.light_to_world), across = x - axis_ * dot(x, axis_);
  x_ = across * (1 / length(across));
  y_ = cross(x_, axis_) * (linear_determinant(d.light_to_world) < 0 ? -1.0 : 1.0);
  constexpr int kSteps = 512;
  for (int i = 0; i < kSteps; ++i) mean_ += static_cast<double>(luminance(factor_at(2 * (i + 0.5) / kSteps))) / kSteps;
  if (!profile_) return;
  if (d.ies_normalize && profile_->mean() > 0) profile_scale_ = 1 / profile_->mean();
  mean_ *= profile_->mean() * profile_scale_;
}

// UsdLuxShapingAPI's applyAngleScale.
double LightShaping::profile_angle(double degrees) const {
  if (angle_scale_ == 0) return degrees;
  const double scaled = angle_scale_ > 0 ? degrees / angle_scale_ : (degrees - 180) / -angle_scale_ + 180;
  return std::clamp(scaled, 0.0, 180.0);
}

Rgb LightShaping::factor_at(double one_minus_cos) const {
  const float cone = cone_.attenuation(one_minus_cos);
  if (focus_ == 0) return Rgb(cone);
  const auto focus = static_cast<float>(std::pow(std::abs(1 - one_minus_cos), focus_));
  return lerp(focus_tint_, Rgb(1.0f), focus) * cone;
}

Rgb LightShaping::factor(const Vec3d& direction) const {
  const Vec3d apart = direction - axis_;
  const double one_minus_cos = 0.5 * dot(apart, apart);
  const Rgb factor = factor_at(one_minus_cos);
  if (!profile_ || is_black(factor)) return factor;
  const double vertical = profile_angle(angle_of(one_minus_cos) * kDegrees);
  const double horizontal = std::atan2(dot(direction, y_), dot(direction, x_)) * kDegrees;
  return finite_or_black(factor, profile_->intensity(vertical, horizontal) * profile_scale_);
}

double LightShaping::largest(const Vec3d& direction, double sin_half_angle) const {
  // Directions of rays are rounded to float, and so are the points that they meet.
  constexpr double kRounding = 0x1p-20;
  const double off_axis = std::atan2(length(cross(direction, axis_)), dot(direction, axis_));
  const double half_angle = sin_half_angle < 1 ? std::asin(sin_half_angle) + kRounding : kPiDouble;
  const double nearest = std::max(0.0, off_axis - half_angle), farthest = std::min(kPiDouble, off_axis + half_angle);
  const double s = std::sin(0.5 * nearest);
  const double cone = static_cast<double>(cone_.attenuation(2 * s * s));
  double profile = 1;
  if (profile_) {
    const double least = profile_angle(nearest * kDegrees), most = profile_angle(farthest * kDegrees);
    profile = profile_->largest(std::max(0.0, least - kRounding), most + kRounding) * profile_scale_;
  }
  if (focus_ == 0) return cone * profile;
  const double cosine = std::max(std::cos(nearest), -std::cos(farthest));
  const double focus = std::max(std::pow(std::clamp(cosine, 0.0, 1.0), focus_), 0x1p-150);
  const auto tint = static_cast<double>(luminance(focus_tint_));
  return cone * profile * (tint < 1 ? tint + (1 - tint) * focus : tint);
}

}  // namespace alabaster
