// Directions drawn uniformly over the solid angle of a rectangle (Urena, Fajardo, King 2013, "An Area-Preserving
// Parametrization for Spherical Rectangles").
#pragma once

#include <algorithm>
#include <cmath>

#include "core/math/elementary.h"
#include "core/math/vector.h"

namespace alabaster {

/// A rectangle in the plane at distance 1 from the point that sees it.
class SphericalRectangle {
 public:
  /// x0 < x1, y0 < y1, from the foot of the perpendicular.
  SphericalRectangle(double x0, double x1, double y0, double y1);
  /// 0 where it is lost in the rounding of angles: small rectangles, and those seen edge-on. They are sampled by area.
  double solid_angle() const { return solid_angle_; }
  /// A unit direction; z, towards the plane, is positive.
  Vec3d sample(const Vec2f& u) const;
  /// Per solid angle, of sample(), at a point (x, y, 1) of the rectangle.
  double pdf(const Vec3d& point) const;

 private:
  double x0_, x1_, y0_, y1_;
  double left_re_, left_im_;  // a complex number whose angle is the signed solid angle between x = 0 and x0
  double solid_angle_ = 0;
};

namespace spherical_rectangle {

// Below this solid angle the sum of four angles has lost too many digits to invert; a rectangle that small is either
// far (no rectangle light is sampled by it from there) or seen edge-on (it gives next to nothing).
inline constexpr double kMinSolidAngle = 0x1p-14;

struct Complex {
  double re, im;
};

// The angle of this number is the signed solid angle of the rectangle from x = 0 to x and from y0 to y1 in the plane at
// distance 1: the difference of two corners' angles, atan(x y / d) with d the distance of the corner. Their complex
// numbers (d, x y) divided leave one.
inline Complex edge(double x, double y0, double y1) {
  const double across2 = x * x + 1, d0 = std::sqrt(across2 + y0 * y0), d1 = std::sqrt(across2 + y1 * y1);
  return {d0 * d1 + x * x * y0 * y1, x * (y1 * d0 - y0 * d1)};
}

}  // namespace spherical_rectangle

inline SphericalRectangle::SphericalRectangle(double x0, double x1, double y0, double y1)
    : x0_(x0), x1_(x1), y0_(y0), y1_(y1) {
  const spherical_rectangle::Complex left = spherical_rectangle::edge(x0, y0, y1),
                                     right = spherical_rectangle::edge(x1, y0, y1);
  left_re_ = left.re;
  left_im_ = left.im;
  // The angle of the quotient. Both angles are less than pi, and more than pi together only if one is obtuse.
  double angle = quick_atan2(right.im * left.re - right.re * left.im, right.re * left.re + right.im * left.im);
  if (angle < 0 && (left.re < 0 || right.re < 0)) angle += 2 * std::numbers::pi;
  if (angle >= spherical_rectangle::kMinSolidAngle) solid_angle_ = angle;
}

// Urena et al. 2013, section 4, with the four interior angles written as arc tangents: acos loses half the digits for
// rectangles seen edge-on. G(x) is the solid angle left of x, counted from x = 0.
inline Vec3d SphericalRectangle::sample(const Vec2f& u) const {
  if (solid_angle_ == 0) return normalize(Vec3d(x0_ + u.x * (x1_ - x0_), y0_ + u.y * (y1_ - y0_), 1));
  // Sine and cosine of g = G(x0) + u.x * solid angle. |left| = (1 + x0^2) sqrt(1 + y0^2) sqrt(1 + y1^2).
  const double c0 = std::sqrt(1 + y0_ * y0_), c1 = std::sqrt(1 + y1_ * y1_), across2 = 1 + x0_ * x0_;
  const double per_left = 1 / (across2 * c0 * c1);
  const auto [sin_turn, cos_turn] = quick_sine_cosine(u.x * solid_angle_);
  const double cos_g = (left_re_ * cos_turn - left_im_ * sin_turn) * per_left;
  const double sin_g = (left_im_ * cos_turn + left_re_ * sin_turn) * per_left;
  // x = sign(f) / sqrt(f^2 - 1 / (1 + y0^2)), f = (far_edge - near_edge cos g) / sin g.
  const double near_edge = y0_ * across2 * c1 * per_left, far_edge = y1_ * across2 * c0 * per_left;
  const double difference = far_edge - near_edge * cos_g, sine_by_c0 = sin_g * across2 * c1 * per_left;
  const double reach = difference * difference - sine_by_c0 * sine_by_c0;
  const double side = std::copysign(1.0, difference) * sin_g;
  const double x =
      std::clamp(reach > 0 ? std::copysign(sin_g / std::sqrt(reach), side) : std::copysign(x1_ - x0_, side), x0_, x1_);
  // The direction's y is uniform between those of the two edges.
  const double d2 = x * x + 1, d0 = std::sqrt(d2 + y0_ * y0_), d1 = std::sqrt(d2 + y1_ * y1_), per_d = 1 / (d0 * d1);
  const double h0 = y0_ * d1 * per_d, h1 = y1_ * d0 * per_d, h = h0 + u.y * (h1 - h0);
  const double z = std::sqrt(std::max(0.0, (1 - h * h) / d2)), lower = y0_ * z, upper = y1_ * z;
  if (h >= lower && h <= upper && z > 0) [[likely]]
    return {x * z, h, z};
  return normalize(Vec3d(x, h > upper ? y1_ : y0_, 1));
}

// By area: d^3 / A, the cosine being 1 / d.
inline double SphericalRectangle::pdf(const Vec3d& point) const {
  if (solid_angle_ > 0) return 1 / solid_angle_;
  const double d2 = dot(point, point);
  return d2 * std::sqrt(d2) / ((x1_ - x0_) * (y1_ - y0_));
}

}  // namespace alabaster
