#include "core/light/dome_light.h"

#include "core/sampling/warp.h"

namespace alabaster {
namespace {

constexpr float kLargestHalf = 65504;

float clean(float channel) {
  if (std::isnan(channel) || channel < 0) return 0;
  return std::isinf(channel) ? kLargestHalf : channel;
}

// cos(a) - cos(b) over one row of texels, without cancellation: 2 sin(middle) sin(half the height).
double row_height(int row, int rows) {
  return 2 * std::sin(kPiDouble * (row + 0.5) / rows) * std::sin(kPiDouble * 0.5 / rows);
}

// Mean over a texel of the bilinear interpolation of it and its neighbours: 1/8, 6/8, 1/8 along each axis.
double filtered(double before, double here, double after) {
  return 0.125 * (before + after) + 0.75 * here;
}

}  // namespace

DomeLight::DomeLight(const LightDescription& description, const Vec3d& /*render_origin*/) {
  const Matrix4d& m = description.light_to_world;
  if (!is_valid_affine(m)) return;
  const Vec3d y = transform_vector(Vec3d(0, 1, 0), m), z = transform_vector(Vec3d(0, 0, 1), m);
  y_ = y * (1 / length(y));
  const Vec3d across = z - y_ * dot(z, y_);
  z_ = across * (1 / length(across));
  x_ = cross(y_, z_) * (linear_determinant(m) < 0 ? -1.0 : 1.0);
  if (!std::isfinite(dot(x_, x_) + dot(y_, y_) + dot(z_, z_))) return;
  scale_ = emission(description);
  if (is_black(scale_) || !description.texture) return;
  if (description.texture->width() <= 0 || description.texture->height() <= 0) return;
  texture_ = description.texture;
  width_ = texture_->width();
  height_ = texture_->height();
  build_distribution();
}

Rgb DomeLight::texel(int x, int y) const {
  const Rgb c = texture_->texel(x, y);
  return {clean(c.r), clean(c.g), clean(c.b)};
}

void DomeLight::build_distribution() {
  const auto w = static_cast<size_t>(width_), h = static_cast<size_t>(height_);
  std::vector<float> along_rows(w * h), weights(w * h), row(w);
  double mean[3] = {0, 0, 0};
  for (int y = 0; y < height_; ++y) {
    const double solid_angle = 2 * kPiDouble / width_ * row_height(y, height_);
    for (int x = 0; x < width_; ++x) {
      const Rgb c = texel(x, y);
      row[static_cast<size_t>(x)] = luminance(c * scale_);
      for (int i = 0; i < 3; ++i) mean[i] += c[i] * (solid_angle / (4 * kPiDouble));
    }
    float* out = &along_rows[static_cast<size_t>(y) * w];
    for (size_t x = 0; x < w; ++x)
      out[x] = static_cast<float>(filtered(row[(x + w - 1) % w], row[x], row[(x + 1) % w]));
  }
  for (size_t y = 0; y < h; ++y) {
    const float *above = &along_rows[(y > 0 ? y - 1 : 0) * w], *here = &along_rows[y * w],
                *below = &along_rows[std::min(y + 1, h - 1) * w];
    const double height = row_height(static_cast<int>(y), height_);
    for (size_t x = 0; x < w; ++x)
      weights[y * w + x] = static_cast<float>(filtered(above[x], here[x], below[x]) * height);
  }
  for (int i = 0; i < 3; ++i) mean_[i] = static_cast<float>(mean[i]);
  distribution_ = std::make_shared<Distribution2D>(weights, w, h);
}

Rgb DomeLight::lookup(double longitude_turns, double colatitude_turns) const {
  const double x = longitude_turns * width_ - 0.5, y = colatitude_turns * height_ - 0.5;
  const int column = static_cast<int>(std::floor(x)), row = static_cast<int>(std::floor(y));
  const auto fx = static_cast<float>(x - column), fy = static_cast<float>(y - row);
  const int x0 = (column + width_) % width_, x1 = (column + 1) % width_;
  const int y0 = std::clamp(row, 0, height_ - 1), y1 = std::clamp(row + 1, 0, height_ - 1);
  return scale_ * lerp(lerp(texel(x0, y0), texel(x1, y0), fx), lerp(texel(x0, y1), texel(x1, y1), fx), fy);
}

// From density over the unit square of texels to solid angle: a texel has area 1/(w h) there, and fills
// 2 pi / w * row_height on the sphere.
float DomeLight::pdf_of_cell(double pdf_uv, int row) const {
  return static_cast<float>(pdf_uv / (2 * kPiDouble * height_ * row_height(row, height_)));
}

std::optional<LightSample> DomeLight::sample(const Vec3f& /*p*/, const Vec2f& u) const {
  if (is_black(scale_) || (texture_ && is_black(mean_))) return std::nullopt;
  LightSample s;
  s.distance = kInfinity;
  if (!texture_) {
    s.wi = sample_uniform_sphere(u);
    s.pdf = pdf_uniform_sphere();
    s.radiance = scale_;
    return s;
  }
  float pdf = 0;
  const Vec2f cell = distribution_->sample(u, &pdf);
  // Within a row: uniform in cos(colatitude), which is uniform in solid angle.
  const double y = static_cast<double>(cell.y) * height_;
  const int row = std::min(static_cast<int>(y), height_ - 1);
  const double top = kPiDouble * row / height_;
  const double one_minus_cos = 2 * std::sin(0.5 * top) * std::sin(0.5 * top) + (y - row) * row_height(row, height_);
  const double sine = std::sqrt(std::max(0.0, one_minus_cos * (2 - one_minus_cos))), cosine = 1 - one_minus_cos;
  const double longitude = 2 * kPiDouble * (0.5 - static_cast<double>(cell.x));
  s.wi = to_float(x_ * (sine * std::sin(longitude)) + y_ * cosine + z_ * (sine * std::cos(longitude)));
  s.pdf = pdf_of_cell(pdf, row);
  s.radiance = lookup(cell.x, std::atan2(sine, cosine) / kPiDouble);
  if (is_black(s.radiance) || !(s.pdf > 0) || !std::isfinite(s.pdf)) return std::nullopt;
  return s;
}

std::optional<LightHit> DomeLight::intersect(const Ray& ray) const {
  if (is_black(scale_)) return std::nullopt;
  if (!texture_) return LightHit{kInfinity, scale_, pdf_uniform_sphere()};
  const Vec3d w(ray.dir);
  const double x = dot(w, x_), y = dot(w, y_), z = dot(w, z_), across = std::sqrt(x * x + z * z);
  if (!(across + std::abs(y) > 0)) return std::nullopt;
  const double u = std::clamp(0.5 - std::atan2(x, z) / (2 * kPiDouble), 0.0, 1.0);
  const double v = std::atan2(across, y) / kPiDouble;
  LightHit hit;
  hit.t = kInfinity;
  hit.radiance = lookup(u, v);
  if (is_black(hit.radiance)) return std::nullopt;
  const int row = std::min(static_cast<int>(v * height_), height_ - 1);
  // The middle of the row: rounding v to float must not leave it.
  const Vec2f cell(static_cast<float>(u), (static_cast<float>(row) + 0.5f) / static_cast<float>(height_));
  hit.pdf = pdf_of_cell(distribution_->pdf(cell), row);
  return hit;
}

double DomeLight::importance(const Vec3f& /*p*/) const {
  return representable_importance(texture_ ? scale_ * mean_ : scale_, kPiDouble);
}

LightExtent DomeLight::extent() const {
  return {{}, importance({}), false};
}

}  // namespace alabaster
