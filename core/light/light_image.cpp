#include "core/light/light_image.h"

namespace alabaster {
namespace {

constexpr float kLargestHalf = 65504;

float clean(float channel) {
  if (std::isnan(channel) || channel < 0) return 0;
  return std::isinf(channel) ? kLargestHalf : channel;
}

// Mean over a texel of the bilinear interpolation of it and its neighbours: 1/8, 6/8, 1/8 along each axis.
double filtered(double before, double here, double after) {
  return 0.125 * (before + after) + 0.75 * here;
}

}  // namespace

double row_height(int row, int rows) {
  return 2 * std::sin(kPiDouble * (row + 0.5) / rows) * std::sin(kPiDouble * 0.5 / rows);
}

Rgb LightImage::texel(int x, int y) const {
  const Rgb c = texture_->texel(x, y);
  return {clean(c.r), clean(c.g), clean(c.b)};
}

LightImage::LightImage(std::shared_ptr<const Texture> texture, const Rgb& scale, Shape shape, const CancelToken& cancel)
    : texture_(std::move(texture)), scale_(scale), shape_(shape) {
  const int width = texture_->width(), height = texture_->height();
  const auto w = static_cast<size_t>(width), h = static_cast<size_t>(height);
  const bool around = shape_ == Shape::lat_long;
  std::vector<float> along_rows(w * h), weights(w * h), row(w);
  double mean[3] = {0, 0, 0};
  for (int y = 0; y < height; ++y) {
    cancel.check();
    const double solid_angle = 2 * kPiDouble / width * row_height(y, height);
    const double share = around ? solid_angle / (4 * kPiDouble) : 1 / (static_cast<double>(width) * height);
    for (int x = 0; x < width; ++x) {
      const Rgb c = texel(x, y);
      row[static_cast<size_t>(x)] = luminance(c * scale_);
      for (int i = 0; i < 3; ++i) mean[i] += c[i] * share;
    }
    float* out = &along_rows[static_cast<size_t>(y) * w];
    for (size_t x = 0; x < w; ++x) {
      const size_t before = x > 0 ? x - 1 : around ? w - 1 : 0, after = x + 1 < w ? x + 1 : around ? 0 : x;
      out[x] = static_cast<float>(filtered(row[before], row[x], row[after]));
    }
  }
  for (size_t y = 0; y < h; ++y) {
    cancel.check();
    const float *above = &along_rows[(y > 0 ? y - 1 : 0) * w], *here = &along_rows[y * w],
                *below = &along_rows[std::min(y + 1, h - 1) * w];
    const double weight = around ? row_height(static_cast<int>(y), height) : 1;
    for (size_t x = 0; x < w; ++x)
      weights[y * w + x] = static_cast<float>(filtered(above[x], here[x], below[x]) * weight);
  }
  for (int i = 0; i < 3; ++i) mean_[i] = static_cast<float>(mean[i]) * scale_[i];
  distribution_ = Distribution2D(weights, w, h, cancel);
}

std::shared_ptr<const LightImage> share_light_image(const std::shared_ptr<const Texture>& texture, const Rgb& scale,
                                                    LightImage::Shape shape, const LightImages& images) {
  for (const auto& image : images.known)
    if (image->is_of(texture.get(), scale, shape)) return image;
  MemoryReservation memory(images.memory, MemoryUse::lights, LightImage::build_bytes(*texture),
                           "the light of an image of " + std::to_string(texture->width()) + " x " +
                               std::to_string(texture->height()) + " pixels");
  const auto image = std::make_shared<LightImage>(texture, scale, shape, images.cancel);
  image->hold(std::move(memory));
  return image;
}

// Two arrays of luminances, and the density: a cumulative one and a guide.
size_t LightImage::build_bytes(const Texture& texture) {
  return 4 * sizeof(float) * static_cast<size_t>(texture.width()) * static_cast<size_t>(texture.height());
}

Rgb LightImage::lookup(double u, double v) const {
  const int width = texture_->width(), height = texture_->height();
  const double x = u * width - 0.5, y = v * height - 0.5;
  const int column = static_cast<int>(std::floor(x)), row = static_cast<int>(std::floor(y));
  const auto fx = static_cast<float>(x - column), fy = static_cast<float>(y - row);
  const auto in_row = [&](int i) {
    return shape_ == Shape::lat_long ? (i + width) % width : std::clamp(i, 0, width - 1);
  };
  const int x0 = in_row(column), x1 = in_row(column + 1);
  const int y0 = std::clamp(row, 0, height - 1), y1 = std::clamp(row + 1, 0, height - 1);
  return scale_ * lerp(lerp(texel(x0, y0), texel(x1, y0), fx), lerp(texel(x0, y1), texel(x1, y1), fx), fy);
}

}  // namespace alabaster
