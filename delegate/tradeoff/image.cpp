#include "delegate/tradeoff/image.h"

#include <cmath>
#include <limits>

#include "delegate/host/display_transform.h"

namespace alabaster::tradeoff {

Image mean_image(std::span<const Image> images) {
  if (images.empty()) return {};
  Image mean = images[0];
  std::vector<double> sum(mean.rgb.size(), 0.0);
  for (const Image& image : images)
    for (size_t i = 0; i < sum.size(); ++i) sum[i] += double(image.rgb[i]);
  for (size_t i = 0; i < sum.size(); ++i) mean.rgb[i] = static_cast<float>(sum[i] / double(images.size()));
  return mean;
}

std::optional<Image> to_display(const Image& linear, const hd::RenderProduct& product,
                                const hd::host::OutputColors& colors, const hd::DiagnosticSink& sink) {
  const auto display = hd::host::DisplayTransform::Create(product, colors, sink);
  if (!display) return std::nullopt;
  Image shown = linear;
  std::vector<float> rgba(shown.rgb.size() / 3 * 4, 1.0f);
  for (size_t i = 0; i < shown.rgb.size(); ++i) rgba[i / 3 * 4 + i % 3] = shown.rgb[i];
  display->Apply(rgba);
  for (size_t i = 0; i < shown.rgb.size(); ++i) shown.rgb[i] = rgba[i / 3 * 4 + i % 3];
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
