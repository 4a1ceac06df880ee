#include "delegate/host/display_transform.h"

#include <algorithm>
#include <cmath>

#include "core/math/float_environment.h"
#include "delegate/host/output_transform.h"

namespace alabaster::hd::host {

DisplayTransform::DisplayTransform(std::shared_ptr<const ColorTransform> transform)
    : transform_(std::move(transform)) {}
DisplayTransform::~DisplayTransform() = default;

std::unique_ptr<DisplayTransform> DisplayTransform::Create(const RenderProduct& product, const OutputColors& colors,
                                                           const DiagnosticSink& sink) {
  const FloatEnvironment environment;
  try {
    ProductPlan plan;
    plan.display_referred = true;
    RenderProduct as_rendered = product;
    as_rendered.exposure = 0;
    OutputTransform out;
    if (!make_output_transform(as_rendered, plan, colors, sink, out)) return nullptr;
    std::unique_ptr<DisplayTransform> display(new DisplayTransform(std::move(out.transform)));
    if (display->SetExposure(product.exposure)) return display;
    if (sink)
      sink({Severity::error, "display.exposure", product.file,
            "exposure must be a number of stops between -126 and 127"});
  } catch (const std::exception& e) {
    if (sink) sink({Severity::error, "display.transform", product.file, e.what()});
  }
  return nullptr;
}

bool DisplayTransform::SetExposure(float stops) {
  const FloatEnvironment environment;
  if (!(stops >= -126 && stops <= 127)) return false;
  scale_ = std::exp2(stops);
  return true;
}

void DisplayTransform::Apply(std::span<float> rgba) const {
  const FloatEnvironment environment;
  const float scale = scale_;
  for (size_t i = 0; i < rgba.size(); i += 4)
    for (size_t c = 0; c < 3; ++c) rgba[i + c] *= scale;
  transform_->apply(rgba.data(), rgba.size() / 4);
  for (size_t i = 0; i < rgba.size(); i += 4)
    for (size_t c = 0; c < 3; ++c) {
      const float v = rgba[i + c];
      rgba[i + c] = v > 0 ? std::min(v, 1.0f) : 0.0f;  // a NaN is black
    }
}

}  // namespace alabaster::hd::host
