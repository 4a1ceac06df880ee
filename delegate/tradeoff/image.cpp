#include "delegate/tradeoff/image.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "delegate/host/display_transform.h"

namespace alabaster::tradeoff {

Image picture_of(const hd::host::ProductImage& picture, const char* aov) {
  const auto found = picture.aovs.find(aov);
  if (found == picture.aovs.end() || found->second.components < 3) return {};
  const hd::host::AovPixels& color = found->second;
  Image image{picture.framing.dataWindow.width(), picture.framing.dataWindow.height(), {}};
  image.rgb.reserve(3 * image.pixels());
  for (int y = 0; y < image.height; ++y) {
    const float* pixel = &color.floats[picture.row_begin(color, y)];
    for (int x = 0; x < image.width; ++x, pixel += color.components)
      image.rgb.insert(image.rgb.end(), pixel, pixel + 3);
  }
  const bool finite = std::all_of(image.rgb.begin(), image.rgb.end(), [](float v) { return std::isfinite(v); });
  return finite ? image : Image{};
}

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
