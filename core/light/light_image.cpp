#include "core/light/light_image.h"

#include <tbb/parallel_for.h>

#include "core/math/largest_half.h"

namespace alabaster {
namespace {

constexpr float kLargest = 1e30f;  // sums over an image, and products with a light's scale, stay floats

float clean(float channel) {
  if (channel >= 0 && channel < kLargest) [[likely]]
    return channel;
  return !(channel > 0) ? 0 : std::isinf(channel) ? kLargestHalf : kLargest;
}

// The measure of rows: v, or 1 - cos(colatitude), which is even in solid angle and precise at the upper pole.
double measure(double v, bool lat_long) {
  const double s = std::sin(0.5 * kPiDouble * v);
  return lat_long ? 2 * s * s : v;
}

double inverse_measure(double m, bool lat_long) {
  return lat_long ? 2 * std::asin(std::min(1.0, std::sqrt(0.5 * m))) / kPiDouble : m;
}

// Draws x from a density over [0, 1) that is linear from a at 0 to b at 1.
double sample_linear(double u, double a, double b) {
  const double sum = a + std::sqrt(std::lerp(a * a, b * b, u));
  return sum > 0 ? u * (a + b) / sum : u;
}

double bilinear(const float (&corners)[4], double s, double t) {
  return std::lerp(std::lerp(corners[0], corners[1], s), std::lerp(corners[2], corners[3], s), t);
}

}  // namespace

Rgb LightImage::texel(int x, int y) const {
  const Rgb c = texture_->texel(x, y);
  return {clean(c.r), clean(c.g), clean(c.b)};
}

Rgb LightImage::tint_of(const Rgb& scale) {
  const float largest = max_component(scale);
  return {scale.r / largest, scale.g / largest, scale.b / largest};
}

LightImage::LightImage(std::shared_ptr<const Texture> texture, const Rgb& tint, Shape shape, const CancelToken& cancel)
    : texture_(std::move(texture)), tint_(tint), shape_(shape) {
  const int width = texture_->width(), height = texture_->height();
  for (int y = 0; y <= height + 1; ++y)
    row_bounds_.push_back(measure(std::clamp(y - 0.5, 0.0, 1.0 * height) / height, wraps()));

  std::vector<float> brightness;
  mean_ = sum_texels(&brightness, cancel);
  std::vector<double> widths(columns());  // of cells, in texels
  for (size_t column = 0; column < columns(); ++column) widths[column] = cell(column, 0).width * width;
  const auto weigh_row = [&](size_t row, std::span<float> weights) {
    const Cell first = cell(0, row);
    const double tall = first.height * height;
    const float* const above = brightness.data() + static_cast<size_t>(first.y0) * static_cast<size_t>(width);
    const float* const below = brightness.data() + static_cast<size_t>(first.y1) * static_cast<size_t>(width);
    auto x0 = static_cast<size_t>(first.x0);
    for (size_t column = 0; column < weights.size(); ++column) {
      const size_t x1 = std::min(column, static_cast<size_t>(width) - 1);
      const double corners = (1.0 * above[x0] + above[x1]) + (1.0 * below[x0] + below[x1]);
      weights[column] = static_cast<float>(0.25 * corners * widths[column] * tall);
      x0 = x1;
    }
  };
  distribution_ = Distribution2D(columns(), rows(), weigh_row, cancel);
}

Rgb LightImage::sum_texels(std::vector<float>* brightness, const CancelToken& cancel) const {
  const auto width = static_cast<size_t>(texture_->width()), height = static_cast<size_t>(texture_->height());
  brightness->resize(width * height);
  std::vector<std::array<double, 3>> rows(height);
  tbb::parallel_for(size_t(0), height, [&](size_t y) {
    cancel.check();
    float* const row = brightness->data() + y * width;
    std::array<double, 3>& sum = rows[y];
    for (size_t x = 0; x < width; ++x) {
      const Rgb c = texel(static_cast<int>(x), static_cast<int>(y));
      row[x] = luminance(c * tint_);
      for (size_t i = 0; i < 3; ++i) sum[i] += static_cast<double>(c[static_cast<int>(i)]);
    }
  });
  double mean[3] = {0, 0, 0};
  for (size_t y = 0; y < height; ++y) {
    const double top = measure(1.0 * static_cast<double>(y) / static_cast<double>(height), wraps());
    const double bottom = measure((static_cast<double>(y) + 1.0) / static_cast<double>(height), wraps());
    const double share = (bottom - top) / (measure(1, wraps()) * static_cast<double>(width));
    for (size_t i = 0; i < 3; ++i) mean[i] += rows[y][i] * share;
  }
  return {static_cast<float>(mean[0]), static_cast<float>(mean[1]), static_cast<float>(mean[2])};
}

LightImage::Cell LightImage::cell(size_t column, size_t row) const {
  const int width = texture_->width(), height = texture_->height();
  const int right = static_cast<int>(column), below = static_cast<int>(row);
  Cell c{column, row};
  c.x0 = right > 0 ? right - 1 : wraps() ? width - 1 : 0;
  c.x1 = std::min(right, width - 1);
  c.y0 = std::max(below - 1, 0);
  c.y1 = std::min(below, height - 1);
  const double begin = wraps() ? right - 0.5 : std::max(right - 0.5, 0.0);
  c.left = begin / width;
  c.width = ((wraps() ? right + 0.5 : std::min(right + 0.5, 1.0 * width)) - begin) / width;
  c.top = row_bounds_[row];
  c.height = row_bounds_[row + 1] - c.top;
  return c;
}

std::shared_ptr<const LightImage> share_light_image(const std::shared_ptr<const Texture>& texture, const Rgb& scale,
                                                    LightImage::Shape shape, const LightImages& images) {
  if (images.same) return images.same;
  const Rgb tint = LightImage::tint_of(scale);
  for (const auto& image : images.known)
    if (image->is_of(texture.get(), tint, shape)) return image;
  MemoryReservation memory(images.memory, MemoryUse::lights, LightImage::build_bytes(*texture),
                           "the light of an image of " + std::to_string(texture->width()) + " x " +
                               std::to_string(texture->height()) + " pixels");
  const auto image = std::make_shared<LightImage>(texture, tint, shape, images.cancel);
  image->hold(std::move(memory));
  return image;
}

// For each cell the weight, and the density: a cumulative number and a guide. For each row its bound, its distribution
// and its sum; two rows of luminances.
size_t LightImage::build_bytes(const Texture& texture) {
  const size_t columns = static_cast<size_t>(texture.width()) + 1, rows = static_cast<size_t>(texture.height()) + 2;
  return 3 * sizeof(float) * columns * rows + (2 * sizeof(Distribution1D) + 4 * sizeof(double)) * rows +
         2 * sizeof(float) * columns;
}

// Farin's bilinear patch, drawn row first: Pharr, Jakob, Humphreys, Physically Based Rendering, 4th edition, 2.4.2.
LightImage::Place LightImage::sample(const Vec2f& u) const {
  const Distribution2D::Cell drawn = distribution_.sample(u);
  const Cell at = cell(drawn.x, drawn.y);
  const float c[4] = {brightness(at.x0, at.y0), brightness(at.x1, at.y0), brightness(at.x0, at.y1),
                      brightness(at.x1, at.y1)};
  const double t = sample_linear(drawn.remapped.y, 1.0 * c[0] + c[1], 1.0 * c[2] + c[3]);
  const double s = sample_linear(drawn.remapped.x, std::lerp(c[0], c[2], t), std::lerp(c[1], c[3], t));
  const double left = at.left + s * at.width;
  return {left < 0 ? left + 1 : left, inverse_measure(at.top + t * at.height, wraps())};
}

LightImage::Look LightImage::look(const Place& place, const Rgb& scale) const {
  const int width = texture_->width(), height = texture_->height();
  const double x = place.u * width + 0.5, y = place.v * height + 0.5;
  const auto column = static_cast<size_t>(std::clamp(x, 0.0, 1.0 * width));
  const Cell at = cell(column % columns(), static_cast<size_t>(std::clamp(y, 0.0, 1.0 * height)));
  const Rgb c[4] = {texel(at.x0, at.y0), texel(at.x1, at.y0), texel(at.x0, at.y1), texel(at.x1, at.y1)};
  const double s = x - static_cast<double>(column);
  const auto across = static_cast<float>(s), down = static_cast<float>(y - static_cast<double>(at.row));
  Look look{scale * lerp(lerp(c[0], c[1], across), lerp(c[2], c[3], across), down)};
  if (is_black(look.radiance)) return look;

  float brightness[4];
  for (int i = 0; i < 4; ++i) brightness[i] = luminance(c[i] * tint_);
  const double mean = bilinear(brightness, 0.5, 0.5);
  if (!(mean > 0)) return look;
  const double t = std::clamp((measure(place.v, wraps()) - at.top) / at.height, 0.0, 1.0);
  const double in_cell = bilinear(brightness, s, t) / mean;
  look.density = distribution_.probability(at.column, at.row) * in_cell / (at.width * at.height);
  if (wraps()) look.density /= 2 * kPiDouble;
  return look;
}

}  // namespace alabaster
