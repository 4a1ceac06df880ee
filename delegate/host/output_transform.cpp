#include "delegate/host/output_transform.h"

namespace alabaster::hd::host {

alabaster::DiagnosticSink to_core(const DiagnosticSink& sink) {
  if (!sink) return {};
  return [sink](const alabaster::Diagnostic& d) { sink({Severity(int(d.severity)), d.code, d.where, d.text}); };
}
static_assert(int(Severity::info) == int(alabaster::Severity::info) &&
              int(Severity::warning) == int(alabaster::Severity::warning) &&
              int(Severity::error) == int(alabaster::Severity::error));

std::shared_ptr<const ColorConfig> OutputColors::config(const DiagnosticSink& sink) const {
  return held ? held : ColorConfig::load(ocio, to_core(sink), within);
}

bool make_output_transform(const RenderProduct& product, const ProductPlan& plan, const OutputColors& colors,
                           const DiagnosticSink& sink, OutputTransform& out) {
  const alabaster::DiagnosticSink core_sink = to_core(sink);
  out.config = colors.config(sink);
  if (!out.config) return false;
  if (plan.display_referred) {
    const std::string display = product.display.empty() ? out.config->default_display() : product.display;
    const std::string view = product.view.empty() ? out.config->default_view(display) : product.view;
    out.transform = out.config->display_transform({display, view, product.look, product.exposure}, core_sink);
    out.description = display + " / " + view;
    if (out.transform && plan.kind != FileKind::exr) out.encoding = out.config->code_points(display, view);
  } else {
    const std::string space = product.colorSpace.empty() ? out.config->rendering_space() : product.colorSpace;
    out.transform = out.config->from_rendering_space(space, core_sink);
    out.description = space;
  }
  return out.transform != nullptr;
}

}  // namespace alabaster::hd::host
