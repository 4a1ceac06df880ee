// The picture of a pass as it is now, as a file, while the pass goes on.
#pragma once

#include "delegate/host/product_writer.h"

namespace alabaster::hd::host {

/// Writes `product` from the buffers that `state`, with which `pass` was executed last, binds. Each is as large as the
/// data window. The AOVs of the product's vars (color, if it has none) must be bound, of any format; buffers of eight
/// or sixteen bits give no more than these. A file of an unfinished render is marked incomplete, and all have the
/// settings and statistics as attributes. Returns false after a report. Host thread.
ALABASTER_API bool WriteSnapshot(const RenderDelegate& delegate, RenderPass& pass, const RenderPassState& state,
                                 const RenderProduct& product, const OutputColors& colors, const DiagnosticSink& sink);

}  // namespace alabaster::hd::host
