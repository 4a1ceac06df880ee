#include "core/light/cylinder_light.h"

namespace alabaster {

CylinderLight::CylinderLight(const LightParameters& parameters, const Vec3d& render_origin) {
  const Matrix4d& m = parameters.light_to_world;
  if (!is_valid_affine(m)) return;
  const Vec3d x = transform_vector(Vec3d(1, 0, 0), m);
  const double x_length = length(x);
  center_ = transform_point(Vec3d(0, 0, 0), m) - render_origin;
  axis_ = x * (1 / x_length);
  half_length_ = 0.5 * x_length * std::abs(static_cast<double>(parameters.length));
  radius_ = std::sqrt(std::abs(linear_determinant(m)) / x_length) * std::abs(static_cast<double>(parameters.radius));
  const double area = 4 * kPiDouble * radius_ * half_length_;
  if (!std::isfinite(dot(center_, axis_) + area) || !(area > 0)) return;
  radiance_ = finite_or_black(emission(parameters), parameters.normalize ? 1 / area : 1);
  shaping_ = LightShaping::make(parameters);
}

// The visible side lies between the plane that touches the cylinder and the line where the outermost directions do.
// Seen from the point, lengths along the axis shrink there by d / (d + r). Widths: the tangent of asin(r / d).
std::optional<CylinderLight::View> CylinderLight::view_from(const Vec3d& p) const {
  const Vec3d from_center = p - center_;
  const double along = dot(from_center, axis_);
  const Vec3d away = from_center - axis_ * along;
  const double distance = length(away), height = distance - radius_;
  if (!(height > 0)) return std::nullopt;
  const Vec3d out = away * (1 / distance);
  const double farther = distance / (distance + radius_), unit = 1 / height;
  const double begin = (-half_length_ - along) * unit, end = (half_length_ - along) * unit;
  const double width = radius_ / std::sqrt(height * (distance + radius_));
  return View{
      out,    cross(axis_, out),
      along,  distance,
      height, SphericalRectangle(std::min(begin, begin * farther), std::max(end, end * farther), -width, width)};
}

// Nearer root of the circle's equation across the axis, written without a difference of nearly equal terms.
std::optional<double> CylinderLight::meet(const View& v, double x, double y) const {
  const double tangent2 = v.height * (v.distance + radius_);  // squared length to where a direction touches the circle
  const double root = radius_ * radius_ - y * y * tangent2;
  if (!(root >= 0)) return std::nullopt;
  const double t = tangent2 / (v.distance + std::sqrt(root));
  if (!(std::abs(v.along + t * x) <= half_length_)) return std::nullopt;
  return t;
}

std::optional<LightSample> CylinderLight::sample(const Vec3f& p, const Vec2f& u, const Vec3f& /*n*/) const {
  if (is_black(radiance_)) return std::nullopt;
  const auto v = view_from(Vec3d(p));
  if (!v) return std::nullopt;
  const Vec3d direction = v->window.sample(u);
  const double stretch = 1 / direction.z;
  const Vec3d point = direction * stretch;
  const auto t = meet(*v, point.x, point.y);
  if (!t) return std::nullopt;
  const Vec3d wi = axis_ * direction.x + v->across * direction.y - v->out * direction.z;
  LightSample s;
  s.wi = to_float(wi);
  s.distance = static_cast<float>(*t * stretch);
  s.radiance = shaped(radiance_, shaping_, -wi);
  s.pdf = static_cast<float>(v->window.pdf(point));
  if (!(s.pdf > 0) || !std::isfinite(s.pdf) || is_black(s.radiance)) return std::nullopt;
  if (!(s.distance > 0) || !std::isfinite(s.distance)) return std::nullopt;
  return s;
}

std::optional<LightHit> CylinderLight::intersect(const Ray& ray, const Vec3f& /*n*/) const {
  if (is_black(radiance_)) return std::nullopt;
  const auto v = view_from(Vec3d(ray.org));
  if (!v) return std::nullopt;
  const Vec3d direction(ray.dir);
  const double towards = -dot(direction, v->out);
  if (!(towards > 0)) return std::nullopt;
  const Vec3d point(dot(direction, axis_) / towards, dot(direction, v->across) / towards, 1);
  const auto t = meet(*v, point.x, point.y);
  if (!t) return std::nullopt;
  LightHit hit;
  hit.t = static_cast<float>(*t / towards);
  hit.radiance = shaped(radiance_, shaping_, direction * (-1 / length(direction)));
  hit.pdf = static_cast<float>(v->window.pdf(point));
  if (!(hit.t > 0) || !std::isfinite(hit.t) || !(hit.pdf > 0) || !std::isfinite(hit.pdf)) return std::nullopt;
  if (is_black(hit.radiance)) return std::nullopt;
  return hit;
}

bool CylinderLight::is_below(const Vec3f& p, const Vec3f& n) const {
  const Vec3d d = center_ - Vec3d(p), normal(n);
  return is_wholly_below(dot(d, normal), half_length_ * std::abs(dot(axis_, normal)) + radius_,
                         std::abs(d.x) + std::abs(d.y) + std::abs(d.z));
}

// A line of radiance 2 r L seen at its nearest distance n: 2 r L l / n^2 from afar, pi r L / n from near. The sine of
// the angle at which it is seen is softened by its size.
double CylinderLight::importance(const Vec3f& p) const {
  const Vec3d d = Vec3d(p) - center_;
  const double along = dot(d, axis_), distance = length(d - axis_ * along), size = 2 * half_length_;
  if (!(distance > radius_)) return 0;
  const double beyond = std::max(0.0, std::abs(along) - half_length_);
  const double nearest2 = distance * distance + beyond * beyond, center_distance = length(d);
  const double sine = (distance + size) / (center_distance + size);
  const double reach = half_length_ + radius_;
  const double spot = shaping_ ? shaping_->largest(d * (1 / center_distance), reach / center_distance) : 1;
  return representable_importance(
      radiance_, spot * 2 * radius_ * size * sine / (nearest2 + size * std::sqrt(nearest2) * (2 / kPiDouble)));
}

LightExtent CylinderLight::extent() const {
  const auto reach = [this](double x) { return half_length_ * std::abs(x) + radius_; };
  const Vec3d r(reach(axis_.x), reach(axis_.y), reach(axis_.z));
  return shaped(
      LightExtent{{center_ - r, center_ + r}, representable_importance(radiance_, 4 * radius_ * half_length_)},
      shaping_);
}

}  // namespace alabaster
