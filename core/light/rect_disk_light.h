// A rectangle or a disk that emits on one side.
// Units, frames, pdfs and the treatment of bad values, common to all lights: light_parameters.h, light.h.
#pragma once

#include "core/light/light_image.h"
#include "core/light/light_parameters.h"
#include "core/light/light_shaping.h"
#include "core/light/spherical_rectangle.h"
#include "core/sampling/warp.h"

namespace alabaster {

/// A rectangle or a disk in the local xy plane about the origin, emitting down local -z only (UsdLuxRectLight,
/// UsdLuxDiskLight). A disk becomes an ellipse under a transform that scales unevenly.
///
/// A rectangle without an image is sampled in one of two ways, mostly. From near, directions are drawn uniformly over
/// its solid angle, so that sample weights stay bounded however near the point is: the variance of the irradiance under
/// a unit square is 16 times less than by area at distance 1, 60 times at 0.1. From farther away, places are drawn by a
/// density that is bilinear between the irradiances of the four corners, which knows the cosine at the surface too
/// (after Hart, Pharr, Mueller, Lopes, McGuire, Shirley 2020, "Practical Product Sampling by Fitting and Composing
/// Warps"). It costs less, and leaves less noise but on the axis. Points are drawn uniformly over the area where the
/// solid angle is lost in the rounding of angles, and where a shear has made the rectangle a parallelogram.
///
/// A rectangle may show an image: upright and not mirrored for who faces it with its +y up, its first texel at (+x, +y)
/// (UsdLuxRectLight). Places are then drawn by its density (light_image.h).
///
/// A disk is sampled by area, but from near, where its weights would vary, as the square around it is (Gamito 2016,
/// "Solid Angle Sampling of Disk and Cylinder Lights"): directions that miss it, a fifth, give no light.
class RectDiskLight {
 public:
  RectDiskLight(const LightParameters& parameters, const Vec3d& render_origin, const LightImages& images = {});
  /// Empty for points behind or in the plane of the light. `n`: unit, a lobe at p weighs light by the cosine to it;
  /// zero: none does.
  std::optional<LightSample> sample(const Vec3f& p, const Vec2f& u, const Vec3f& n = Vec3f(0, 0, 0)) const;
  /// The pdf is that of sample(ray.org, ., n).
  std::optional<LightHit> intersect(const Ray& ray, const Vec3f& n = Vec3f(0, 0, 0)) const;
  /// 0 exactly behind and in the plane, and outside the spot of every part.
  double importance(const Vec3f& p) const;
  LightExtent extent() const;
  /// True only if every direction from p to the light lies below the plane through p with unit normal n.
  bool is_below(const Vec3f& p, const Vec3f& n) const;
  /// Null: the same radiance everywhere.
  const std::shared_ptr<const LightImage>& image() const { return image_; }

 private:
  bool is_sampled_by_area(const Vec3d& to_center, double height) const;
  /// The rectangle as seen from a point in front.
  SphericalRectangle view_from(const Vec3d& to_center, double height) const;
  /// 0 where it is sampled by area.
  double solid_angle(const Vec3d& to_center, double height) const;
  /// Where on the light a point of its plane lies, given from the centre: in half edges along x and y, each in [-1, 1].
  struct Place {
    double x, y;
    LightImage::Place image_place() const { return {0.5 - 0.5 * x, 0.5 - 0.5 * y}; }
  };
  std::optional<Place> place_of(const Vec3d& from_center) const;
  /// Where a point sees the light, and what it knows of its surface.
  struct View {
    Vec3d to_center;
    double height;  // over the light's plane
    Vec3f n;
  };
  /// The density of places on a rectangle that is not near; else empty.
  std::optional<BilinearDensity> corner_irradiances(const View& from) const;
  template <bool kPlain>
  std::optional<LightSample> sample_as(const View& from, const Vec2f& u) const;
  double pdf_of(const View& from, const Place& place, double density, double distance) const;
  /// Per solid angle. `density`: of places in the unit square, 1 where they are uniform.
  double pdf_by_area(double density, double distance, double height) const {
    return density * distance * distance * distance / (area_ * height);
  }

  bool disk_ = false;
  bool plain_ = false;  // a rectangle with right angles, without image and shaping
  Vec3d center_{0, 0, 0};
  Vec3d x_{1, 0, 0}, y_{0, 1, 0}, n_{0, 0, 1};  // unit: along width, along height, normal of the emitting side
  double half_width_ = 0, half_height_ = 0;     // half edge lengths, of the rectangle around a disk
  double skew_ = 0;                             // dot(x_, y_); exactly 0 for a rectangle
  double area_ = 0;
  Rgb radiance_{0.0f};  // of an image: its mean
  Rgb image_scale_{0.0f};
  std::shared_ptr<const LightImage> image_;
  std::shared_ptr<const LightShaping> shaping_;
};

}  // namespace alabaster
