#include "core/light/light_image.h"

namespace alabaster {
namespace {

constexpr float kLargestHalf = 65504;

float clean(float channel) {
  if (std::isnan(channel) || channel < 0) return 0;
  return std::isinf(channel) ? kLargestHalf : channel;
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

  const auto w = static_cast<size_t>(width);
  std::vector<float> above(w), here(w), weights;
  weights.reserve(columns() * rows());
  double mean[3] = {0, 0, 0};
  for (int y = 0; y <= height; ++y) {
    cancel.check();
    const double top = measure(1.0 * y / height, wraps()), bottom = measure((y + 1.0) / height, wraps());
    const double share = (bottom - top) / (measure(1, wraps()) * width);
    for (int x = 0; x < width && y < height; ++x) {
      const Rgb c = texel(x, y);
      here[static_cast<size_t>(x)] = luminance(c * tint_);
      for (int i = 0; i < 3; ++i) mean[i] += c[i] * share;
    }
    if (y == 0) above = here;
    for (size_t column = 0; column < columns(); ++column) {
      const Cell at = cell(column, static_cast<size_t>(y));
      const auto x0 = static_cast<size_t>(at.x0), x1 = static_cast<size_t>(at.x1);
      const double corners = (1.0 * above[x0] + above[x1]) + (1.0 * here[x0] + here[x1]);
      weights.push_back(static_cast<float>(0.25 * corners * (at.width * width) * (at.height * height)));
    }
    std::swap(above, here);
    if (y + 1 == height) here = above;
  }
  for (int i = 0; i < 3; ++i) mean_[i] = static_cast<float>(mean[i]);
  distribution_ = Distribution2D(weights, columns(), rows(), cancel);
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
