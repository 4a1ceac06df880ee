// Turns resolved AOVs into the bytes of a product's rows. Internal to this room.
#pragma once

#include <vector>

#include "delegate/host/product_plan.h"
#include "delegate/host/product_writer.h"

namespace alabaster {
class ColorTransform;
}

namespace alabaster::hd::host {

/// A file's Z where no surface was hit. The renderer's cameraDepth is 0 there, which compositors would take for the
/// nearest surface of all. Cycles writes 1e10 too; unlike infinity it survives filters.
inline constexpr float kFarAway = 1e10f;

/// Converts rows of the image to rows of the file: channels interleaved, in their file types. `plan`, `image` and
/// `transform` must outlive it and fit each other.
class RowEncoder final : public RowSource {
 public:
  RowEncoder(const ProductPlan& plan, const ProductImage& image, const ColorTransform& transform);
  /// Runs on all threads of the caller's arena.
  void encode(int begin, int end, uint8_t* out) const override;
  size_t row_bytes() const override { return pixel_bytes_ * width_; }

 private:
  struct Column {
    const PlannedChannel* channel;
    const AovPixels* pixels;
    size_t color;   // index into colors_, for a channel that is colour
    size_t offset;  // in the bytes of a pixel
  };
  using Scratch = std::vector<std::vector<float>>;  // one RGBA row for each of colors_

  void encode_row(int row, Scratch& scratch, uint8_t* out) const;
  void convert(const AovPixels& pixels, int row, std::vector<float>& rgba) const;
  void store(const Column& column, int row, const Scratch& scratch, uint8_t* out) const;
  template <class Value>
  void store_as(const Column& column, int row, uint8_t* out, const Value& value) const;

  const ProductPlan& plan_;
  const ProductImage& image_;
  const ColorTransform& transform_;
  size_t width_, pixel_bytes_ = 0;
  std::vector<const AovPixels*> colors_;
  std::vector<Column> columns_;
};

}  // namespace alabaster::hd::host
