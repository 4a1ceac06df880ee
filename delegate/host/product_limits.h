// The limits of the formats that products are written in, checked before anything is rendered.
#pragma once

#include "delegate/host/product_writer.h"

namespace alabaster::hd::host {

/// Checks that the product's file can hold the pixels of `window`, RenderSettingsDescription::window(). Also false
/// where CheckProduct refuses the product's kind or AOVs.
ALABASTER_API ProductCheck CheckProductSize(const RenderProduct& product, const Rect2i& window,
                                            const DiagnosticSink& sink);

}  // namespace alabaster::hd::host
