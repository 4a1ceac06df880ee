// The conversion of one product's colours from the rendering space. Internal to this room.
#pragma once

#include "core/color/color_config.h"
#include "delegate/host/product_plan.h"
#include "delegate/host/product_writer.h"

namespace alabaster::hd::host {

struct OutputTransform {
  std::shared_ptr<const ColorConfig> config;
  std::shared_ptr<const ColorTransform> transform;
  std::string description;  // attribute "colorSpace"
  /// Coding of the values of a PNG, TIFF or JPEG for a display; empty where it is not known.
  std::optional<CodePoints> encoding;
};

/// False after a report if the config cannot be read or lacks a name.
bool make_output_transform(const RenderProduct& product, const ProductPlan& plan, const OutputColors& colors,
                           const DiagnosticSink& sink, OutputTransform& out);

alabaster::DiagnosticSink to_core(const DiagnosticSink& sink);

}  // namespace alabaster::hd::host
