// A tube that emits outwards.
// Units, frames, pdfs and the treatment of bad values, common to all lights: light_parameters.h, light.h.
#pragma once

#include "core/light/light_parameters.h"
#include "core/light/light_shaping.h"
#include "core/light/spherical_rectangle.h"

namespace alabaster {

/// A cylinder about the local x axis, centred on the origin, that emits outwards. It has no end caps, and its inside is
/// dark (UsdLuxCylinderLight).
///
/// Directions are drawn uniformly over the solid angle of a rectangle that stands between the point and the axis and
/// covers the visible side (Gamito 2016, "Solid Angle Sampling of Disk and Cylinder Lights"). Those that pass it by
/// give no light.
class CylinderLight {
 public:
  CylinderLight(const LightParameters& parameters, const Vec3d& render_origin);
  /// Empty for points that see no outside: nearer to the axis than the radius.
  std::optional<LightSample> sample(const Vec3f& p, const Vec2f& u, const Vec3f& n = Vec3f(0, 0, 0)) const;
  std::optional<LightHit> intersect(const Ray& ray, const Vec3f& n = Vec3f(0, 0, 0)) const;
  /// 0 where no outside is seen, and outside the spot of every part.
  double importance(const Vec3f& p) const;
  LightExtent extent() const;
  std::shared_ptr<const LightImage> image() const { return nullptr; }
  /// True only if every direction from p to the light lies below the plane through p with unit normal n.
  bool is_below(const Vec3f& p, const Vec3f& n) const;

 private:
  /// The cylinder as seen from a point outside.
  struct View {
    Vec3d out, across;  // unit, perpendicular to the axis: from it to the point, and along the rectangle
    double along;       // of the point, on the axis
    double distance;    // to the axis
    double height;      // above the rectangle, which touches the cylinder: distance - radius
    SphericalRectangle window;
  };
  std::optional<View> view_from(const Vec3d& p) const;
  /// Where the direction (x along the axis, y across, 1 towards it) meets the visible side, in units of itself.
  std::optional<double> meet(const View& view, double x, double y) const;

  Vec3d center_{0, 0, 0};
  Vec3d axis_{1, 0, 0};
  double half_length_ = 0, radius_ = 0;
  Rgb radiance_{0.0f};
  std::shared_ptr<const LightShaping> shaping_;
};

}  // namespace alabaster
