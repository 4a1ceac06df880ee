#include "core/light/dome_light.h"

#include "core/math/frame.h"
#include "core/sampling/warp.h"

namespace alabaster {
DomeLight::DomeLight(const LightParameters& parameters, const Vec3d& /*render_origin*/, const LightImages& images) {
  const Matrix4d& m = parameters.light_to_world;
  if (!is_valid_affine(m)) return;
  const Vec3d y = transform_vector(Vec3d(0, 1, 0), m), z = transform_vector(Vec3d(0, 0, 1), m);
  y_ = y * (1 / length(y));
  const Vec3d across = z - y_ * dot(z, y_);
  z_ = across * (1 / length(across));
  x_ = cross(y_, z_) * (linear_determinant(m) < 0 ? -1.0 : 1.0);
  if (!std::isfinite(dot(x_, x_) + dot(y_, y_) + dot(z_, z_))) return;
  radiance_ = emission(parameters);
  const auto& texture = parameters.texture;
  if (is_black(radiance_) || !texture || texture->width() <= 0 || texture->height() <= 0) return;
  image_ = share_light_image(texture, radiance_, LightImage::Shape::lat_long, images);
  image_scale_ = radiance_;
  radiance_ = image_->mean(image_scale_);
}

namespace {

// The density of directions to a constant dome.
float constant_pdf(const Vec3f& wi, const Vec3f& n) {
  return n == Vec3f(0, 0, 0) ? pdf_uniform_sphere() : std::max(0.0f, dot(wi, n)) * kInvPi;
}

}  // namespace

std::optional<LightSample> DomeLight::sample(const Vec3f& /*p*/, const Vec2f& u, const Vec3f& n) const {
  if (is_black(radiance_)) return std::nullopt;
  LightSample s;
  s.distance = kInfinity;
  if (!image_) {
    s.wi = n == Vec3f(0, 0, 0) ? sample_uniform_sphere(u) : frame_from_normal(n).to_world(sample_cosine_hemisphere(u));
    s.pdf = constant_pdf(s.wi, n);
    s.radiance = radiance_;
    if (!(s.pdf > 0)) return std::nullopt;
    return s;
  }
  const LightImage::Place place = image_->sample(u);
  const double colatitude = kPiDouble * place.v, longitude = 2 * kPiDouble * (0.5 - place.u);
  const double sine = std::sin(colatitude), cosine = std::cos(colatitude);
  s.wi = to_float(x_ * (sine * std::sin(longitude)) + y_ * cosine + z_ * (sine * std::cos(longitude)));
  const LightImage::Look look = image_->look(place, image_scale_);
  s.pdf = static_cast<float>(look.density);
  s.radiance = look.radiance;
  if (is_black(s.radiance) || !(s.pdf > 0) || !std::isfinite(s.pdf)) return std::nullopt;
  return s;
}

std::optional<LightHit> DomeLight::intersect(const Ray& ray, const Vec3f& n) const {
  if (is_black(radiance_)) return std::nullopt;
  if (!image_) return LightHit{kInfinity, radiance_, constant_pdf(ray.dir, n)};
  const Vec3d w(ray.dir);
  const double x = dot(w, x_), y = dot(w, y_), z = dot(w, z_), across = std::sqrt(x * x + z * z);
  if (!(across + std::abs(y) > 0)) return std::nullopt;
  const double u = std::clamp(0.5 - std::atan2(x, z) / (2 * kPiDouble), 0.0, 1.0);
  const double v = std::atan2(across, y) / kPiDouble;
  LightHit hit;
  hit.t = kInfinity;
  const LightImage::Look look = image_->look({u, v}, image_scale_);
  hit.radiance = look.radiance;
  hit.pdf = static_cast<float>(look.density);
  if (is_black(hit.radiance)) return std::nullopt;
  return hit;
}

double DomeLight::importance(const Vec3f& /*p*/) const {
  return representable_importance(radiance_, kPiDouble);
}

LightExtent DomeLight::extent() const {
  return {{}, importance({}), false};
}

}  // namespace alabaster
