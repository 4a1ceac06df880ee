// A product as it will be written, planned once for the checks before rendering and for the writing. Internal to this
// room.
#pragma once

#include "delegate/host/output_transform.h"

namespace alabaster::hd::host {

struct PlannedProduct {
  RenderProduct product;
  ProductPlan plan;
  OutputTransform out;
};

/// CheckProduct, and the plan where it is true.
ProductCheck plan_product(const RenderProduct& product, const Rect2i& window, const OutputColors& colors,
                          const DiagnosticSink& sink, PlannedProduct* planned);

/// WriteProducts.
std::vector<std::string> write_planned(const std::vector<PlannedProduct>& products, const ProductImage& image,
                                       const DiagnosticSink& sink);

}  // namespace alabaster::hd::host
