// Images that lights are made of.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/color/rgb.h"
#include "core/memory/memory_budget.h"
#include "core/sampling/distribution.h"
#include "core/texture/texture.h"

namespace alabaster {

/// An image filtered bilinearly, and a density over it that is bilinear too, proportional to the luminance under a
/// tint: light of one colour over its density is the same at all places, so an image of a sun gives no noise of its
/// own. Negative and NaN texels count as black, infinite ones as the largest half float, those beyond 1e30 as that. The
/// texture's own wrap modes do not count. Lights of any brightness share it; each multiplies it by its own scale.
///
/// Places are (u to the right, v DOWN) in the unit square.
class LightImage {
 public:
  enum class Shape {
    flat,     // clamped at its edges; densities per unit square
    lat_long  // wraps around in u, is clamped at the poles; densities per solid angle
  };
  /// `tint`: of the density (tint_of). The texture has texels. Throws BuildCancelled.
  LightImage(std::shared_ptr<const Texture> texture, const Rgb& tint, Shape shape, const CancelToken& cancel = {});
  /// Over its largest channel, which is positive.
  static Rgb tint_of(const Rgb& scale);
  /// Bytes that the constructor takes at most.
  static size_t build_bytes(const Texture& texture);
  /// Keeps what counts its memory.
  void hold(MemoryReservation memory) {
    memory_ = std::move(memory);
    memory_.shrink(memory_bytes());
  }

  struct Place {
    double u = 0, v = 0;
  };
  struct Look {
    Rgb radiance;
    double density = 0;  // with which sample() gives this place; positive wherever there is radiance
  };
  Look look(const Place& place, const Rgb& scale) const;
  Place sample(const Vec2f& u) const;
  /// By area, or over the sphere.
  Rgb mean(const Rgb& scale) const { return mean_ * scale; }
  const Texture* texture() const { return texture_.get(); }
  bool is_of(const Texture* texture, const Rgb& tint, Shape shape) const {
    return texture_.get() == texture && tint_ == tint && shape_ == shape;
  }
  /// On the heap, without the texture, which others may share.
  size_t memory_bytes() const {
    return sizeof(*this) + row_bounds_.capacity() * sizeof(double) + distribution_.memory_bytes();
  }

 private:
  /// The rectangle between the centres of four texels; at a clamped edge, half of one.
  struct Cell {
    size_t column = 0, row = 0;          // column 0 lies at and left of the centres of the first texels
    int x0 = 0, x1 = 0, y0 = 0, y1 = 0;  // the texels of its corners
    double left = 0, width = 0;          // in u
    double top = 0, height = 0;          // in the measure of rows
  };
  Cell cell(size_t column, size_t row) const;
  /// The mean of the texels, and the luminance of each under the tint.
  Rgb sum_texels(std::vector<float>* brightness, const CancelToken& cancel) const;
  bool wraps() const { return shape_ == Shape::lat_long; }
  size_t columns() const { return static_cast<size_t>(texture_->width()) + (wraps() ? 0 : 1); }
  size_t rows() const { return static_cast<size_t>(texture_->height()) + 1; }
  Rgb texel(int x, int y) const;
  float brightness(int x, int y) const { return luminance(texel(x, y) * tint_); }

  std::shared_ptr<const Texture> texture_;
  Rgb tint_;
  Shape shape_;
  Rgb mean_{0.0f};
  std::vector<double> row_bounds_;  // of cells, in the measure of rows
  Distribution2D distribution_;     // over cells
  MemoryReservation memory_;
};

/// Images that exist already; the token that those to be made ask, and the budget that counts them (may be null).
struct LightImages {
  std::span<const std::shared_ptr<const LightImage>> known = {};
  CancelToken cancel = {};
  std::shared_ptr<MemoryBudget> memory = nullptr;
  std::shared_ptr<const LightImage> same = nullptr;  // of the light elsewhere: taken whatever the rounding of its tint
};

/// The known one of that texture, tint and shape, or a new one: its density takes 0.2 s for 4096 x 2048 texels. Throws
/// MemoryRefused and BuildCancelled.
std::shared_ptr<const LightImage> share_light_image(const std::shared_ptr<const Texture>& texture, const Rgb& scale,
                                                    LightImage::Shape shape, const LightImages& images);

}  // namespace alabaster
