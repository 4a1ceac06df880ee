#include "delegate/tradeoff/image.h"

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

}  // namespace alabaster::tradeoff
