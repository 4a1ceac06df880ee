// Images that lights are made of.
#pragma once

#include <memory>
#include <span>

#include "core/color/rgb.h"
#include "core/memory/memory_budget.h"
#include "core/sampling/distribution.h"
#include "core/texture/texture.h"

namespace alabaster {

/// An image filtered bilinearly, and a density over it that is constant per texel, proportional to the mean of the
/// FILTERED luminance over the texel: it is positive wherever the filtered image is. Negative and NaN texels count as
/// black, infinite ones as the largest half float. The texture's own wrap modes do not count.
///
/// Places are (u to the right, v DOWN) in the unit square.
class LightImage {
 public:
  enum class Shape {
    flat,     // clamped at its edges, a texel counts by its area
    lat_long  // wraps around in u, is clamped at the poles, and a texel counts by its solid angle
  };
  /// The image times `scale`. The texture has texels. Throws BuildCancelled.
  LightImage(std::shared_ptr<const Texture> texture, const Rgb& scale, Shape shape, const CancelToken& cancel = {});
  /// Bytes that the constructor takes at most.
  static size_t build_bytes(const Texture& texture);
  /// Keeps what counts its memory.
  void hold(MemoryReservation memory) {
    memory_ = std::move(memory);
    memory_.shrink(memory_bytes());
  }

  Rgb lookup(double u, double v) const;
  /// A place and its density per unit square.
  Vec2f sample(const Vec2f& u, float* pdf) const { return distribution_.sample(u, pdf); }
  float pdf(const Vec2f& place) const { return distribution_.pdf(place); }
  /// By area, or over the sphere.
  const Rgb& mean() const { return mean_; }
  int height() const { return texture_->height(); }
  const Texture* texture() const { return texture_.get(); }
  bool is_of(const Texture* texture, const Rgb& scale, Shape shape) const {
    return texture_.get() == texture && scale_ == scale && shape_ == shape;
  }
  /// On the heap, without the texture, which others may share.
  size_t memory_bytes() const { return sizeof(*this) + distribution_.memory_bytes(); }

 private:
  Rgb texel(int x, int y) const;

  std::shared_ptr<const Texture> texture_;
  Rgb scale_;
  Shape shape_;
  Rgb mean_{0.0f};
  Distribution2D distribution_;
  MemoryReservation memory_;
};

/// Images that exist already; the token that those to be made ask, and the budget that counts them (may be null).
struct LightImages {
  std::span<const std::shared_ptr<const LightImage>> known = {};
  CancelToken cancel = {};
  std::shared_ptr<MemoryBudget> memory = nullptr;
};

/// The known one that is made of the same, or a new one: its density takes 0.2 s for 4096 x 2048 texels. Throws
/// MemoryRefused and BuildCancelled.
std::shared_ptr<const LightImage> share_light_image(const std::shared_ptr<const Texture>& texture, const Rgb& scale,
                                                    LightImage::Shape shape, const LightImages& images);

/// cos(a) - cos(b) of the colatitudes over one row of texels of a lat-long image, without cancellation:
/// 2 sin(middle) sin(half the height).
double row_height(int row, int rows);

}  // namespace alabaster
