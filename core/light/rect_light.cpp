#include "core/light/rect_light.h"

namespace alabaster {
namespace {

// Below this solid angle the sum of four angles has lost too many digits to invert; a rectangle that small is either
// far (density by area is then as good) or seen edge-on (it gives next to nothing).
constexpr double kMinSolidAngle = 0x1p-14;
// Beyond this skew (cosine of the angle between the edges) it is a parallelogram; below, rounding of the transform.
constexpr double kMaxSkew = 0x1p-20;

// Signed solid angle of the rectangle from x = 0 to x and from y0 to y1 in the plane at distance z: the difference of
// two corners' angles, atan(x y / (z d)) with d the distance of the corner. Their complex numbers (z d, x y) divided
// leave one arc tangent.
double edge_angle(double x, double y0, double y1, double z) {
  const double across2 = x * x + z * z;
  const double re0 = z * std::sqrt(across2 + y0 * y0), re1 = z * std::sqrt(across2 + y1 * y1);
  return std::atan2(x * (y1 * re0 - y0 * re1), re0 * re1 + x * x * y0 * y1);
}

}  // namespace

RectLight::RectLight(const LightDescription& description, const Vec3d& render_origin) {
  const Matrix4d& m = description.light_to_world;
  if (!is_valid_affine(m)) return;
  const Vec3d x = transform_vector(Vec3d(1, 0, 0), m), y = transform_vector(Vec3d(0, 1, 0), m);
  const double x_length = length(x), y_length = length(y);
  half_width_ = 0.5 * x_length * std::abs(static_cast<double>(description.width));
  half_height_ = 0.5 * y_length * std::abs(static_cast<double>(description.height));
  center_ = transform_point(Vec3d(0, 0, 0), m) - render_origin;
  x_ = x * (1 / x_length);
  y_ = y * (1 / y_length);
  const Vec3d normal = cross(x_, y_);
  const double sine = length(normal);
  n_ = normal * (1 / sine);
  skew_ = dot(x_, y_);
  if (std::abs(skew_) < kMaxSkew) {
    skew_ = 0;
    y_ = cross(n_, x_);
  }
  if (dot(n_, transform_vector(Vec3d(0, 0, -1), m)) < 0) n_ = -n_;
  area_ = 4 * half_width_ * half_height_ * sine;
  const double finite = dot(center_, n_) + area_ + dot(x_, y_);
  if (std::isfinite(finite) && area_ > 0)
    radiance_ = finite_or_black(emission(description), description.normalize ? 1 / area_ : 1);
}

RectLight::View RectLight::view_from(const Vec3d& p) const {
  const Vec3d d = center_ - p;
  View v;
  const double x = dot(d, x_), y = dot(d, y_);
  v.x0 = x - half_width_;
  v.x1 = x + half_width_;
  v.y0 = y - half_height_;
  v.y1 = y + half_height_;
  v.z = -dot(d, n_);
  v.solid_angle = 0;
  if (skew_ != 0 || !(v.z > 0)) return v;
  v.left_angle = edge_angle(v.x0, v.y0, v.y1, v.z);
  const double angle = edge_angle(v.x1, v.y0, v.y1, v.z) - v.left_angle;
  if (angle >= kMinSolidAngle) v.solid_angle = angle;
  return v;
}

// Urena et al. 2013, section 4, with the four interior angles written as arc tangents: acos loses half the digits for
// rectangles seen edge-on. G(x) is the solid angle left of x, counted from x = 0.
Vec3d RectLight::sample_solid_angle(const View& v, const Vec2f& u) const {
  const double z2 = v.z * v.z;
  const double g = v.left_angle + u.x * v.solid_angle;
  const double near_edge = v.y0 / std::sqrt(v.y0 * v.y0 + z2), far_edge = v.y1 / std::sqrt(v.y1 * v.y1 + z2);
  const double f = (far_edge - near_edge * std::cos(g)) / std::sin(g);  // infinite at x = 0, with the sign of x
  const double reach = f * f - z2 / (v.y0 * v.y0 + z2);
  const double x =
      std::clamp(reach > 0 ? std::copysign(v.z / std::sqrt(reach), f) : std::copysign(v.x1 - v.x0, f), v.x0, v.x1);
  const double d2 = x * x + z2;
  const double h0 = v.y0 / std::sqrt(d2 + v.y0 * v.y0), h1 = v.y1 / std::sqrt(d2 + v.y1 * v.y1);
  const double h = h0 + u.y * (h1 - h0);
  const double y = h * h < 1 ? std::clamp(h * std::sqrt(d2 / (1 - h * h)), v.y0, v.y1) : (h > 0 ? v.y1 : v.y0);
  return x_ * x + y_ * y - n_ * v.z;
}

std::optional<LightSample> RectLight::sample(const Vec3f& p, const Vec2f& u) const {
  if (is_black(radiance_)) return std::nullopt;
  const View v = view_from(Vec3d(p));
  if (!(v.z > 0)) return std::nullopt;
  const bool by_area = v.solid_angle == 0;
  const Vec3d to_light =
      by_area ? center_ - Vec3d(p) + x_ * (half_width_ * (2 * u.x - 1)) + y_ * (half_height_ * (2 * u.y - 1))
              : sample_solid_angle(v, u);
  const double distance = length(to_light);
  // By area: d^2 / (A cos) with cos = z / d.
  const double pdf = by_area ? distance * distance * distance / (area_ * v.z) : 1 / v.solid_angle;
  LightSample s;
  s.wi = to_float(to_light * (1 / distance));
  s.distance = static_cast<float>(distance);
  s.radiance = radiance_;
  s.pdf = static_cast<float>(pdf);
  if (!(s.pdf > 0) || !std::isfinite(s.pdf)) return std::nullopt;
  if (!(s.distance > 0) || !std::isfinite(s.distance)) return std::nullopt;
  return s;
}

std::optional<LightHit> RectLight::intersect(const Ray& ray) const {
  if (is_black(radiance_)) return std::nullopt;
  const Vec3d origin(ray.org), direction(ray.dir);
  const double towards = -dot(direction, n_), height = dot(origin - center_, n_);
  if (!(towards > 0) || !(height > 0)) return std::nullopt;
  const double t = height / towards;
  const Vec3d q = origin - center_ + direction * t;
  // Coordinates along edges that need not be perpendicular.
  const double along_x = dot(q, x_), along_y = dot(q, y_), unskew = 1 / (1 - skew_ * skew_);
  if (!(std::abs(along_x - skew_ * along_y) * unskew <= half_width_)) return std::nullopt;
  if (!(std::abs(along_y - skew_ * along_x) * unskew <= half_height_)) return std::nullopt;
  const View v = view_from(origin);
  const double distance = t * length(direction);
  LightHit hit;
  hit.t = static_cast<float>(t);
  hit.radiance = radiance_;
  hit.pdf =
      static_cast<float>(v.solid_angle > 0 ? 1 / v.solid_angle : distance * distance * distance / (area_ * height));
  if (!(hit.t > 0) || !std::isfinite(hit.t) || !(hit.pdf > 0) || !std::isfinite(hit.pdf)) return std::nullopt;
  return hit;
}

// Irradiance from a disk of the same area on its axis at the distance of the centre, L A / (d^2 + A / pi), times the
// cosine at the light. The cosine is softened by the light's size: near the plane, the nearest part of the rectangle is
// still overhead.
double RectLight::importance(const Vec3f& p) const {
  const Vec3d d = center_ - Vec3d(p);
  const double z = -dot(d, n_);
  if (!(z > 0)) return 0;
  const double d2 = dot(d, d), size = half_width_ + half_height_;
  const double cosine = (z + size) / (std::sqrt(d2) + size);
  return representable_importance(radiance_, area_ * cosine / (d2 + area_ * static_cast<double>(kInvPi)));
}

LightExtent RectLight::extent() const {
  LightExtent extent{{}, representable_importance(radiance_, area_)};
  for (const double x : {-half_width_, half_width_})
    for (const double y : {-half_height_, half_height_}) extent.box.extend(center_ + x_ * x + y_ * y);
  return extent;
}

}  // namespace alabaster
