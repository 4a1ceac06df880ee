// Light from all around: a sky or an image.
// Units, frames, pdfs and the treatment of bad values, common to all lights: light_description.h, light.h.
#pragma once

#include "core/light/light_description.h"
#include "core/sampling/distribution.h"

namespace alabaster {

/// Light from all directions at infinity: constant, or a lat-long image (UsdLuxDomeLight).
///
/// Orientation is OpenUSD's, which is OpenEXR's for latitude-longitude maps: the top row is the pole +y; the centre of
/// the image looks along +z, longitude 0; a quarter of the width LEFT of it is longitude +pi/2, +x; the left and right
/// edges meet at -z. So u = 1/2 - atan2(x, z) / 2pi and, v being up, v = 1 - acos(y) / pi, all in the light's local
/// axes. (glTF viewers often centre on another axis; turn the dome by its transform.) Only the transform's rotation
/// and mirroring count.
///
/// The image is filtered bilinearly. It wraps around in longitude and is clamped at the poles; the texture's own wrap
/// modes do not count. Directions are drawn from a density that is constant per texel and solid angle, proportional to
/// the mean of the FILTERED luminance over the texel: it is positive wherever the filtered image is. Negative and NaN
/// texels count as black, infinite ones as the largest half float.
class DomeLight {
 public:
  DomeLight(const LightDescription& description, const Vec3d& render_origin);
  std::optional<LightSample> sample(const Vec3f& p, const Vec2f& u) const;
  /// Always hits, at infinity, unless the dome is black or an image is asked for the direction zero.
  std::optional<LightHit> intersect(const Ray& ray) const;
  double importance(const Vec3f& p) const;
  LightExtent extent() const;
  /// Null: a constant dome.
  const Texture* texture() const { return texture_.get(); }
  /// On the heap, without the texture, which others may share.
  size_t memory_bytes() const { return distribution_ ? distribution_->memory_bytes() : 0; }

 private:
  Rgb texel(int x, int y) const;
  Rgb lookup(double longitude_turns, double colatitude_turns) const;
  void build_distribution();
  float pdf_of_cell(double pdf_uv, int row) const;

  Vec3d x_{1, 0, 0}, y_{0, 1, 0}, z_{0, 0, 1};  // the light's axes in render space: orthonormal, perhaps left-handed
  Rgb scale_{0.0f};
  std::shared_ptr<const Texture> texture_;  // null: constant
  int width_ = 0, height_ = 0;
  std::shared_ptr<const Distribution2D> distribution_;  // shared: lights are copied
  Rgb mean_{1.0f};                                      // of the image over the sphere
};

}  // namespace alabaster
