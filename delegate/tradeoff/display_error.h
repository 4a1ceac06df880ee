// How far apart two pictures are once they are on a display: what an eye compares, unlike linear light.
#pragma once

#include <optional>

#include "delegate/host/product_writer.h"
#include "delegate/tradeoff/image.h"

namespace alabaster::tradeoff {

/// `linear` (rendering space, premultiplied) as the display and view of `product` show it, over black, 0 to 1; empty
/// names are the config's defaults. None + report on unknown names or a config that cannot be read.
std::optional<Image> to_display(const Image& linear, const hd::RenderProduct& product,
                                const hd::host::OutputColors& colors, const hd::DiagnosticSink& sink);

/// Root mean square of the differences over pixels and channels; of display pixels it lies between 0 and 1. A NaN if
/// the images differ in size or have none.
double rmse(const Image& a, const Image& b);

}  // namespace alabaster::tradeoff
