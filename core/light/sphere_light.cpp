#include "core/light/sphere_light.h"

#include "core/math/elementary.h"
#include "core/math/frame.h"
#include "core/sampling/warp.h"

namespace alabaster {
namespace {

// 1 - cos of the cone that a sphere of radius r fills at distance d > r, without cancellation:
// sin^2 / (1 + cos), cos^2 = (d - r)(d + r) / d^2.
double one_minus_cos_sphere(double r, double d) {
  const double sin2 = (r / d) * (r / d);
  return sin2 / (1 + std::sqrt((d - r) * (d + r)) / d);
}

// std::cbrt need not give cbrt(8^k x) = 2^k cbrt(x) to the last bit, and the unit of length would show.
double cube_root(double x) {
  int exponent = 0;
  const double mantissa = std::frexp(x, &exponent);
  const int thirds = static_cast<int>(std::floor(exponent / 3.0));
  return std::ldexp(std::cbrt(std::ldexp(mantissa, exponent - 3 * thirds)), thirds);
}

double pdf_outside(double r, double d) {
  return 1 / (2 * kPiDouble * one_minus_cos_sphere(r, d));
}

}  // namespace

SphereLight::SphereLight(const LightParameters& parameters, const Vec3d& render_origin) {
  const Matrix4d& m = parameters.light_to_world;
  if (!is_valid_affine(m)) return;
  center_ = transform_point(Vec3d(0, 0, 0), m) - render_origin;
  const double scale = cube_root(std::abs(linear_determinant(m)));
  if (!parameters.treat_as_point) radius_ = scale * std::abs(static_cast<double>(parameters.radius));
  if (!std::isfinite(dot(center_, center_)) || !std::isfinite(radius_)) {
    radius_ = 0;
    return;
  }
  // A normalised sphere of any radius has radiant intensity pi r^2 L = I / 4, and so has its limit, a point.
  const double area = is_delta() ? 4 : 4 * kPiDouble * radius_ * radius_;
  radiance_ = finite_or_black(emission(parameters), parameters.normalize ? 1 / area : 1);
  shaping_ = LightShaping::make(parameters);
}

std::optional<LightSample> SphereLight::sample_point(const Vec3d& to_center) const {
  const double d2 = dot(to_center, to_center);
  if (!(d2 > 0)) return std::nullopt;
  const Vec3d wi = to_center * (1 / std::sqrt(d2));
  LightSample s;
  s.wi = to_float(wi);
  s.distance = static_cast<float>(std::sqrt(d2));
  s.radiance = finite_or_black(shaped(radiance_, shaping_, -wi), 1 / d2);
  s.pdf = 1;
  s.delta = true;
  if (is_black(s.radiance)) return std::nullopt;
  return s;
}

std::optional<LightSample> SphereLight::sample(const Vec3f& p, const Vec2f& u, const Vec3f& /*n*/) const {
  if (is_black(radiance_)) return std::nullopt;
  const Vec3d to_center = center_ - Vec3d(p);
  if (is_delta()) return sample_point(to_center);
  const double d = length(to_center);
  Vec3d wi;
  double pdf, distance;
  if (d > radius_) {
    const double one_minus_z = u.x * one_minus_cos_sphere(radius_, d);
    const double sin2 = one_minus_z * (2 - one_minus_z), sine = std::sqrt(sin2);
    const auto [sine_of_azimuth, cosine_of_azimuth] = quick_sine_cosine_turns(u.y);
    const Vec3d axis = to_center * (1 / d);
    const Frame frame = frame_from_normal(to_float(axis));
    wi = Vec3d(frame.s) * (sine * double(cosine_of_azimuth)) + Vec3d(frame.t) * (sine * double(sine_of_azimuth)) +
         axis * (1 - one_minus_z);
    // Nearer root, written without a difference of nearly equal terms.
    const double half_chord = std::sqrt(std::max(0.0, radius_ * radius_ - d * d * sin2));
    distance = (d - radius_) * (d + radius_) / (d * (1 - one_minus_z) + half_chord);
    pdf = pdf_outside(radius_, d);
  } else {
    wi = Vec3d(sample_uniform_sphere(u));
    const double along = dot(to_center, wi);
    distance = along + std::sqrt(along * along + (radius_ - d) * (radius_ + d));
    pdf = static_cast<double>(pdf_uniform_sphere());
  }
  LightSample s;
  s.wi = to_float(wi);
  s.distance = static_cast<float>(distance);
  s.radiance = shaped(radiance_, shaping_, -wi);
  s.pdf = static_cast<float>(pdf);
  if (is_black(s.radiance) || !(s.distance > 0) || !std::isfinite(s.distance)) return std::nullopt;
  if (!(s.pdf > 0) || !std::isfinite(s.pdf)) return std::nullopt;
  return s;
}

std::optional<LightHit> SphereLight::intersect(const Ray& ray, const Vec3f& /*n*/) const {
  if (is_black(radiance_) || is_delta()) return std::nullopt;
  const Vec3d to_center = center_ - Vec3d(ray.org);
  const double speed = length(Vec3d(ray.dir)), d = length(to_center);
  if (!(speed > 0)) return std::nullopt;
  const Vec3d wi = Vec3d(ray.dir) * (1 / speed);
  const double along = dot(to_center, wi);
  const Vec3d miss = to_center - wi * along;
  const double chord2 = radius_ * radius_ - dot(miss, miss);
  const bool outside = d > radius_;
  if (!(chord2 >= 0) || (outside && !(along > 0))) return std::nullopt;
  const double half_chord = std::sqrt(chord2);
  const double t = outside ? (d - radius_) * (d + radius_) / (along + half_chord) : along + half_chord;
  LightHit hit;
  hit.t = static_cast<float>(t / speed);
  hit.radiance = shaped(radiance_, shaping_, -wi);
  hit.pdf = outside ? static_cast<float>(pdf_outside(radius_, d)) : pdf_uniform_sphere();
  if (is_black(hit.radiance) || !(hit.t > 0) || !std::isfinite(hit.t) || !std::isfinite(hit.pdf)) return std::nullopt;
  return hit;
}

bool SphereLight::is_below(const Vec3f& p, const Vec3f& n) const {
  const Vec3d d = center_ - Vec3d(p);
  return is_wholly_below(dot(d, Vec3d(n)), radius_, std::abs(d.x) + std::abs(d.y) + std::abs(d.z));
}

// I / d^2 for a point, pi L (r / d)^2 for a sphere wholly above the horizon (inside it, pi L), dimmed by the spot.
double SphereLight::importance(const Vec3f& p) const {
  const Vec3d from_center = Vec3d(p) - center_;
  const double d2 = dot(from_center, from_center), r2 = radius_ * radius_;
  if (!is_delta() && !(d2 > r2))
    return representable_importance(radiance_, kPiDouble * (shaping_ ? shaping_->mean() : 1));
  if (!(d2 > 0)) return 0;
  const double d = std::sqrt(d2);
  const double spot = shaping_ ? shaping_->largest(from_center * (1 / d), radius_ / d) : 1;
  return representable_importance(radiance_, spot * (is_delta() ? 1 : kPiDouble * r2) / d2);
}

LightExtent SphereLight::extent() const {
  const Vec3d r(radius_, radius_, radius_);
  return shaped(LightExtent{{center_ - r, center_ + r},
                            representable_importance(radiance_, is_delta() ? 1 : kPiDouble * radius_ * radius_)},
                shaping_);
}

}  // namespace alabaster
