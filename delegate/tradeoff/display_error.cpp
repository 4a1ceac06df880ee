#include "delegate/tradeoff/display_error.h"

#include <cmath>
#include <limits>

namespace alabaster::tradeoff {

std::optional<Image> to_display(const Image& linear, const hd::RenderProduct& product,
                                const hd::host::OutputColors& colors, const hd::DiagnosticSink& sink) {
  Image shown = linear;
  if (!hd::host::ApplyDisplay(product, colors, shown.rgb, sink)) return std::nullopt;
  return shown;
}

double rmse(const Image& a, const Image& b) {
  if (a.width != b.width || a.height != b.height || a.rgb.size() != b.rgb.size() || a.rgb.empty())
    return std::numeric_limits<double>::quiet_NaN();
  double sum = 0;
  for (size_t i = 0; i < a.rgb.size(); ++i) {
    const double difference = double(a.rgb[i]) - double(b.rgb[i]);
    sum += difference * difference;
  }
  return std::sqrt(sum / double(a.rgb.size()));
}

}  // namespace alabaster::tradeoff
