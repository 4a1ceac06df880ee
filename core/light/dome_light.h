// Light from all around: a sky or an image.
// Units, frames, pdfs and the treatment of bad values, common to all lights: light_parameters.h, light.h.
#pragma once

#include "core/light/light_image.h"
#include "core/light/light_parameters.h"

namespace alabaster {

/// Light from all directions at infinity: constant, or a lat-long image (UsdLuxDomeLight).
///
/// Orientation is OpenUSD's, which is OpenEXR's for latitude-longitude maps: the top row is the pole +y; the centre of
/// the image looks along +z, longitude 0; a quarter of the width LEFT of it is longitude +pi/2, +x; the left and right
/// edges meet at -z. So u = 1/2 - atan2(x, z) / 2pi and, v being up, v = 1 - acos(y) / pi, all in the light's local
/// axes. (glTF viewers often centre on another axis; turn the dome by its transform.) Only the transform's rotation
/// and mirroring count.
///
/// Directions are drawn from the image's density (light_image.h). Those of a constant dome are drawn in proportion to
/// the lobe's cosine, where there is one.
class DomeLight {
 public:
  DomeLight(const LightParameters& parameters, const Vec3d& render_origin, const LightImages& images = {});
  /// `n`: unit, a lobe at p weighs light by the cosine to it; zero: none does.
  std::optional<LightSample> sample(const Vec3f& p, const Vec2f& u, const Vec3f& n = Vec3f(0, 0, 0)) const;
  /// Always hits, at infinity, unless the dome is black or an image is asked for the direction zero. The pdf is that of
  /// sample(., ., n).
  std::optional<LightHit> intersect(const Ray& ray, const Vec3f& n = Vec3f(0, 0, 0)) const;
  double importance(const Vec3f& p) const;
  LightExtent extent() const;
  bool is_below(const Vec3f&, const Vec3f&) const { return false; }
  /// Null: a constant dome.
  const std::shared_ptr<const LightImage>& image() const { return image_; }

 private:
  Vec3d x_{1, 0, 0}, y_{0, 1, 0}, z_{0, 0, 1};  // the light's axes in render space: orthonormal, perhaps left-handed
  Rgb radiance_{0.0f};                          // of an image: its mean
  Rgb image_scale_{0.0f};
  std::shared_ptr<const LightImage> image_;  // null: constant
};

}  // namespace alabaster
