// Pictures in memory, for the measurements of `alabaster tradeoff`.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "delegate/host/product_writer.h"

namespace alabaster::tradeoff {

/// Rows top-down, three floats per pixel: red, green, blue. Scene-linear unless a function says otherwise.
struct Image {
  int width = 0, height = 0;
  std::vector<float> rgb;

  size_t pixels() const { return static_cast<size_t>(width) * static_cast<size_t>(height); }
};

/// Red, green and blue of a colour AOV; empty if there is none or a value is not finite.
Image picture_of(const hd::host::ProductImage& picture, const char* aov);

/// The mean of `images`, which must all have one size; summed in double precision. Empty if there are none.
Image mean_image(std::span<const Image> images);

/// `linear` (rendering space, premultiplied) as the display and view of `product` show it, over black, 0 to 1. Empty
/// names stand for the config's defaults. None, after a report, on unknown names or a config that cannot be read.
std::optional<Image> to_display(const Image& linear, const hd::RenderProduct& product,
                                const hd::host::OutputColors& colors, const hd::DiagnosticSink& sink);

/// Root mean square of the differences over pixels and channels; between 0 and 1 for display pixels. NaN if the images
/// differ in size or are empty.
double rmse(const Image& a, const Image& b);

}  // namespace alabaster::tradeoff
