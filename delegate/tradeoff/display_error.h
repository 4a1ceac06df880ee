// The difference of two pictures as displayed. The eye compares those rather than linear light.
#pragma once

#include <optional>

#include "delegate/host/product_writer.h"
#include "delegate/tradeoff/image.h"

namespace alabaster::tradeoff {

/// `linear` (rendering space, premultiplied) as the display and view of `product` show it, over black, 0 to 1. Empty
/// names stand for the config's defaults. None, after a report, on unknown names or a config that cannot be read.
std::optional<Image> to_display(const Image& linear, const hd::RenderProduct& product,
                                const hd::host::OutputColors& colors, const hd::DiagnosticSink& sink);

/// Root mean square of the differences over pixels and channels; between 0 and 1 for display pixels. NaN if the images
/// differ in size or are empty.
double rmse(const Image& a, const Image& b);

}  // namespace alabaster::tradeoff
