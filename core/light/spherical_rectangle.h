// Directions drawn uniformly over the solid angle of a rectangle (Urena, Fajardo, King 2013, "An Area-Preserving
// Parametrization for Spherical Rectangles").
#pragma once

#include "core/math/vector.h"

namespace alabaster {

/// A rectangle in the plane at distance 1 from the point that sees it.
class SphericalRectangle {
 public:
  /// x0 < x1, y0 < y1, from the foot of the perpendicular.
  SphericalRectangle(double x0, double x1, double y0, double y1);
  /// 0 where it is lost in the rounding of angles: small rectangles, and those seen edge-on. They are sampled by area.
  double solid_angle() const { return solid_angle_; }
  /// A point (x, y, 1) of the plane, beyond which the direction goes on.
  Vec3d sample(const Vec2f& u) const;
  /// Per solid angle, of sample(), at a point of the rectangle.
  double pdf(const Vec3d& point) const;

 private:
  double x0_, x1_, y0_, y1_;
  double left_re_, left_im_;  // a complex number whose angle is the signed solid angle between x = 0 and x0
  double solid_angle_ = 0;
};

}  // namespace alabaster
