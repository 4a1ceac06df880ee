// From resolved AOVs to the bytes of a product's rows. Internal to this room.
#pragma once

#include <map>
#include <vector>

#include "delegate/host/product_plan.h"
#include "delegate/host/product_writer.h"

namespace alabaster {
class ColorTransform;
}

namespace alabaster::hd::host {

/// What nothing hit becomes in a file's Z. The renderer's cameraDepth is 0 there, which compositors would take for the
/// nearest thing of all; 1e10 is what Cycles writes, and unlike infinity it survives their filters.
inline constexpr float kFarAway = 1e10f;

/// Converts and stores rows, pixel by pixel, channel after channel. `plan`, `image` and `transform` must outlive it and
/// fit each other.
class RowEncoder {
 public:
  RowEncoder(const ProductPlan& plan, const ProductImage& image, const ColorTransform& transform);
  /// Rows [begin, end) to `out`, `row_bytes` each, in parallel on the threads of the arena it is called in.
  void encode(int begin, int end, uint8_t* out) const;
  size_t row_bytes() const { return pixel_bytes_ * width_; }

 private:
  struct Column {
    const PlannedChannel* channel;
    const AovPixels* pixels;
    size_t color;   // index into colors_, for a channel that is colour
    size_t offset;  // in the bytes of a pixel
  };
  using Scratch = std::vector<std::vector<float>>;  // one RGBA row for each of colors_

  void encode_row(int row, Scratch& scratch, uint8_t* out) const;
  void convert(const AovPixels& pixels, size_t row, std::vector<float>& rgba) const;
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
