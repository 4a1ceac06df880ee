#include "core/light/dome_light.h"

#include "core/sampling/warp.h"

namespace alabaster {
DomeLight::DomeLight(const LightDescription& description, const Vec3d& /*render_origin*/, const LightImages& images) {
  const Matrix4d& m = description.light_to_world;
  if (!is_valid_affine(m)) return;
  const Vec3d y = transform_vector(Vec3d(0, 1, 0), m), z = transform_vector(Vec3d(0, 0, 1), m);
  y_ = y * (1 / length(y));
  const Vec3d across = z - y_ * dot(z, y_);
  z_ = across * (1 / length(across));
  x_ = cross(y_, z_) * (linear_determinant(m) < 0 ? -1.0 : 1.0);
  if (!std::isfinite(dot(x_, x_) + dot(y_, y_) + dot(z_, z_))) return;
  radiance_ = emission(description);
  const auto& texture = description.texture;
  if (is_black(radiance_) || !texture || texture->width() <= 0 || texture->height() <= 0) return;
  image_ = share_light_image(texture, radiance_, LightImage::Shape::lat_long, images);
  radiance_ = image_->mean();
}

// From density over the unit square of texels to solid angle: a texel has area 1/(w h) there, and fills
// 2 pi / w * row_height on the sphere.
float DomeLight::pdf_of_cell(double pdf_uv, int row) const {
  const int rows = image_->height();
  return static_cast<float>(pdf_uv / (2 * kPiDouble * rows * row_height(row, rows)));
}

std::optional<LightSample> DomeLight::sample(const Vec3f& /*p*/, const Vec2f& u) const {
  if (is_black(radiance_)) return std::nullopt;
  LightSample s;
  s.distance = kInfinity;
  if (!image_) {
    s.wi = sample_uniform_sphere(u);
    s.pdf = pdf_uniform_sphere();
    s.radiance = radiance_;
    return s;
  }
  float pdf = 0;
  const Vec2f cell = image_->sample(u, &pdf);
  const int rows = image_->height();
  // Within a row: uniform in cos(colatitude), which is uniform in solid angle.
  const double y = static_cast<double>(cell.y) * rows;
  const int row = std::min(static_cast<int>(y), rows - 1);
  const double top = kPiDouble * row / rows;
  const double one_minus_cos = 2 * std::sin(0.5 * top) * std::sin(0.5 * top) + (y - row) * row_height(row, rows);
  const double sine = std::sqrt(std::max(0.0, one_minus_cos * (2 - one_minus_cos))), cosine = 1 - one_minus_cos;
  const double longitude = 2 * kPiDouble * (0.5 - static_cast<double>(cell.x));
  s.wi = to_float(x_ * (sine * std::sin(longitude)) + y_ * cosine + z_ * (sine * std::cos(longitude)));
  s.pdf = pdf_of_cell(pdf, row);
  s.radiance = image_->lookup(cell.x, std::atan2(sine, cosine) / kPiDouble);
  if (is_black(s.radiance) || !(s.pdf > 0) || !std::isfinite(s.pdf)) return std::nullopt;
  return s;
}

std::optional<LightHit> DomeLight::intersect(const Ray& ray) const {
  if (is_black(radiance_)) return std::nullopt;
  if (!image_) return LightHit{kInfinity, radiance_, pdf_uniform_sphere()};
  const Vec3d w(ray.dir);
  const double x = dot(w, x_), y = dot(w, y_), z = dot(w, z_), across = std::sqrt(x * x + z * z);
  if (!(across + std::abs(y) > 0)) return std::nullopt;
  const double u = std::clamp(0.5 - std::atan2(x, z) / (2 * kPiDouble), 0.0, 1.0);
  const double v = std::atan2(across, y) / kPiDouble;
  LightHit hit;
  hit.t = kInfinity;
  hit.radiance = image_->lookup(u, v);
  if (is_black(hit.radiance)) return std::nullopt;
  const int rows = image_->height(), row = std::min(static_cast<int>(v * rows), rows - 1);
  // The middle of the row: rounding v to float must not leave it.
  const Vec2f cell(static_cast<float>(u), (static_cast<float>(row) + 0.5f) / static_cast<float>(rows));
  hit.pdf = pdf_of_cell(image_->pdf(cell), row);
  return hit;
}

double DomeLight::importance(const Vec3f& /*p*/) const {
  return representable_importance(radiance_, kPiDouble);
}

LightExtent DomeLight::extent() const {
  return {{}, importance({}), false};
}

}  // namespace alabaster
