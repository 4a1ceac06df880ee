#include "core/light/rect_light.h"

namespace alabaster {
namespace {

// Below this solid angle the sum of four angles has lost too many digits to invert; a rectangle that small is either
// far (density by area is then as good) or seen edge-on (it gives next to nothing).
constexpr double kMinSolidAngle = 0x1p-14;
// Beyond this skew (cosine of the angle between the edges) it is a parallelogram; below, rounding of the transform.
constexpr double kMaxSkew = 0x1p-20;

struct Complex {
  double re, im;
};

// The angle of this number is the signed solid angle of the rectangle from x = 0 to x and from y0 to y1 in the plane at
// distance 1: the difference of two corners' angles, atan(x y / d) with d the distance of the corner. Their complex
// numbers (d, x y) divided leave one.
Complex edge(double x, double y0, double y1) {
  const double across2 = x * x + 1, d0 = std::sqrt(across2 + y0 * y0), d1 = std::sqrt(across2 + y1 * y1);
  return {d0 * d1 + x * x * y0 * y1, x * (y1 * d0 - y0 * d1)};
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
  View v{};
  v.z = -dot(d, n_);
  if (skew_ != 0 || !(v.z > 0)) return v;
  const double unit = 1 / v.z, x = dot(d, x_), y = dot(d, y_);
  v.x0 = (x - half_width_) * unit;
  v.x1 = (x + half_width_) * unit;
  v.y0 = (y - half_height_) * unit;
  v.y1 = (y + half_height_) * unit;
  const Complex left = edge(v.x0, v.y0, v.y1), right = edge(v.x1, v.y0, v.y1);
  v.left_re = left.re;
  v.left_im = left.im;
  // Beside the point both angles lie on one side of zero, and the quotient's is less than pi.
  const double angle = v.x0 < 0 && v.x1 > 0 ? std::atan2(right.im, right.re) - std::atan2(left.im, left.re)
                                            : std::atan2(right.im * left.re - right.re * left.im,
                                                         right.re * left.re + right.im * left.im);
  if (angle >= kMinSolidAngle) v.solid_angle = angle;
  return v;
}

// Urena et al. 2013, section 4, with the four interior angles written as arc tangents: acos loses half the digits for
// rectangles seen edge-on. G(x) is the solid angle left of x, counted from x = 0.
Vec3d RectLight::sample_solid_angle(const View& v, const Vec2f& u) const {
  // Sine and cosine of g = G(x0) + u.x * solid angle. |left| = (1 + x0^2) sqrt(1 + y0^2) sqrt(1 + y1^2).
  const double c0 = std::sqrt(1 + v.y0 * v.y0), c1 = std::sqrt(1 + v.y1 * v.y1), across2 = 1 + v.x0 * v.x0;
  const double per_left = 1 / (across2 * c0 * c1), turn = u.x * v.solid_angle;
  const double cos_turn = std::cos(turn), sin_turn = std::sin(turn);
  const double cos_g = (v.left_re * cos_turn - v.left_im * sin_turn) * per_left;
  const double sin_g = (v.left_im * cos_turn + v.left_re * sin_turn) * per_left;
  // x = sign(f) / sqrt(f^2 - 1 / (1 + y0^2)), f = (far_edge - near_edge cos g) / sin g.
  const double near_edge = v.y0 * across2 * c1 * per_left, far_edge = v.y1 * across2 * c0 * per_left;
  const double difference = far_edge - near_edge * cos_g, sine_by_c0 = sin_g * across2 * c1 * per_left;
  const double reach = difference * difference - sine_by_c0 * sine_by_c0;
  const double side = std::copysign(1.0, difference) * sin_g;
  const double x = std::clamp(
      reach > 0 ? std::copysign(sin_g / std::sqrt(reach), side) : std::copysign(v.x1 - v.x0, side), v.x0, v.x1);
  const double d2 = x * x + 1, d0 = std::sqrt(d2 + v.y0 * v.y0), d1 = std::sqrt(d2 + v.y1 * v.y1),
               per_d = 1 / (d0 * d1);
  const double h0 = v.y0 * d1 * per_d, h1 = v.y1 * d0 * per_d, h = h0 + u.y * (h1 - h0);
  const double y = h * h < 1 ? std::clamp(h * std::sqrt(d2 / (1 - h * h)), v.y0, v.y1) : (h > 0 ? v.y1 : v.y0);
  return (x_ * x + y_ * y - n_) * v.z;
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

bool RectLight::is_below(const Vec3f& p, const Vec3f& n) const {
  const Vec3d d = center_ - Vec3d(p), normal(n);
  return is_wholly_below(dot(d, normal),
                         half_width_ * std::abs(dot(x_, normal)) + half_height_ * std::abs(dot(y_, normal)),
                         std::abs(d.x) + std::abs(d.y) + std::abs(d.z));
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
