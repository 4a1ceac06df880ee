#include "core/light/rect_disk_light.h"

namespace alabaster {
namespace {

// Beyond this skew (cosine of the angle between the edges) it is a parallelogram; below, rounding of the transform.
constexpr double kMaxSkew = 0x1p-20;
// A disk is near up to this height above its plane and this distance from its centre, in units of its radius. With 1 to
// 64 samples the standard deviation of the irradiance is then less by the square than by area: a third at height 0.3,
// the same at the bounds.
constexpr double kNearHeight = 0.75, kNearDistance = 2;
// A rectangle is near where its half diagonal squared is more than this share of the squared distance of its centre.
// There its irradiance is no longer nearly bilinear: at half diagonals of 0.71, 0.5 and 0.33 of the distance the
// variance is 1.04, 0.68 and 0.47 of that by solid angle (RectLight.IsSampledWithLessNoiseFromAfar).
constexpr double kNearRectangle = 0.25;
// No corner's n . d counts less than this share of the largest: lobes may be tilted by a normal map, or not be diffuse.
constexpr float kLeastCosine = 0.1f;

}  // namespace

RectDiskLight::RectDiskLight(const LightParameters& parameters, const Vec3d& render_origin, const LightImages& images)
    : disk_(parameters.type == LightType::disk) {
  const Matrix4d& m = parameters.light_to_world;
  if (!is_valid_affine(m)) return;
  const Vec3d x = transform_vector(Vec3d(1, 0, 0), m), y = transform_vector(Vec3d(0, 1, 0), m);
  const double x_length = length(x), y_length = length(y);
  const double width = disk_ ? 2.0 * parameters.radius : parameters.width;
  const double height = disk_ ? width : parameters.height;
  half_width_ = 0.5 * x_length * std::abs(width);
  half_height_ = 0.5 * y_length * std::abs(height);
  center_ = transform_point(Vec3d(0, 0, 0), m) - render_origin;
  x_ = x * (1 / x_length);
  y_ = y * (1 / y_length);
  const Vec3d normal = cross(x_, y_);
  const double sine = length(normal);
  n_ = normal * (1 / sine);
  skew_ = dot(x_, y_);
  if (std::abs(skew_) < kMaxSkew) {
    skew_ = 0;
    y_ = cross(n_, x_);
  }
  if (dot(n_, transform_vector(Vec3d(0, 0, -1), m)) < 0) n_ = -n_;
  area_ = (disk_ ? kPiDouble : 4) * half_width_ * half_height_ * sine;
  const double finite = dot(center_, n_) + area_ + dot(x_, y_);
  if (!std::isfinite(finite) || !(area_ > 0)) return;
  radiance_ = finite_or_black(emission(parameters), parameters.normalize ? 1 / area_ : 1);
  shaping_ = LightShaping::make(parameters);
  plain_ = !disk_ && skew_ == 0 && !shaping_;
  const auto& texture = parameters.texture;
  if (disk_ || is_black(radiance_) || !texture || texture->width() <= 0 || texture->height() <= 0) return;
  image_ = share_light_image(texture, radiance_, LightImage::Shape::flat, images);
  plain_ = false;
  image_scale_ = radiance_;
  radiance_ = image_->mean(image_scale_);
}

bool RectDiskLight::is_sampled_by_area(const Vec3d& to_center, double height) const {
  if (!disk_) return skew_ != 0 || image_;
  const double radius = std::max(half_width_, half_height_), distance = kNearDistance * radius;
  return skew_ != 0 || height > kNearHeight * radius || dot(to_center, to_center) > distance * distance;
}

inline SphericalRectangle RectDiskLight::view_from(const Vec3d& to_center, double height) const {
  const double unit = 1 / height, x = dot(to_center, x_), y = dot(to_center, y_);
  return {(x - half_width_) * unit, (x + half_width_) * unit, (y - half_height_) * unit, (y + half_height_) * unit};
}

double RectDiskLight::solid_angle(const Vec3d& to_center, double height) const {
  return !plain_ && is_sampled_by_area(to_center, height) ? 0 : view_from(to_center, height).solid_angle();
}

std::optional<RectDiskLight::Place> RectDiskLight::place_of(const Vec3d& from_center) const {
  // Coordinates along edges that need not be perpendicular.
  const double along_x = dot(from_center, x_), along_y = dot(from_center, y_), unskew = 1 / (1 - skew_ * skew_);
  const double x = (along_x - skew_ * along_y) * unskew, y = (along_y - skew_ * along_x) * unskew;
  if (!(std::abs(x) <= half_width_ && std::abs(y) <= half_height_)) return std::nullopt;
  const Place place{x / half_width_, y / half_height_};
  if (disk_ && !(place.x * place.x + place.y * place.y <= 1)) return std::nullopt;
  return place;
}

std::optional<LightSample> RectDiskLight::sample(const Vec3f& p, const Vec2f& u, const Vec3f& n) const {
  if (is_black(radiance_)) return std::nullopt;
  const Vec3d to_center = center_ - Vec3d(p);
  const double height = -dot(to_center, n_);
  if (!(height > 0)) return std::nullopt;
  const View from{to_center, height, n};
  return plain_ ? sample_as<true>(from, u) : sample_as<false>(from, u);
}

// A place gives the irradiance L cos cos' dA / d^2 = L (n . d) (n' . d) dA / d^4, and n' . d is the same for all.
std::optional<BilinearDensity> RectDiskLight::corner_irradiances(const View& from) const {
  if (disk_ || skew_ != 0 || image_) return std::nullopt;
  const double distance2 = dot(from.to_center, from.to_center);
  const double half_diagonal2 = half_width_ * half_width_ + half_height_ * half_height_;
  if (!(half_diagonal2 <= kNearRectangle * distance2)) return std::nullopt;
  const double unit = 1 / distance2;
  const auto middle2 = static_cast<float>(1 + half_diagonal2 * unit);
  const auto by_x = static_cast<float>(2 * half_width_ * dot(from.to_center, x_) * unit);
  const auto by_y = static_cast<float>(2 * half_height_ * dot(from.to_center, y_) * unit);
  const Vec3d n(from.n);
  const double per_distance = std::sqrt(unit);
  const auto cosine = static_cast<float>(dot(from.to_center, n) * per_distance);
  const auto cosine_by_x = static_cast<float>(half_width_ * dot(x_, n) * per_distance);
  const auto cosine_by_y = static_cast<float>(half_height_ * dot(y_, n) * per_distance);
  const float largest = cosine + std::abs(cosine_by_x) + std::abs(cosine_by_y);
  const bool weighs = largest > 0;
  const auto irradiance = [&](float x, float y) {
    const float square = middle2 + x * by_x + y * by_y;
    const float lobe =
        weighs ? std::max(cosine + x * cosine_by_x + y * cosine_by_y, kLeastCosine * largest) / largest : 1;
    return lobe / (square * square);
  };
  return BilinearDensity{{irradiance(-1, -1), irradiance(1, -1), irradiance(-1, 1), irradiance(1, 1)}};
}

template <bool kPlain>
std::optional<LightSample> RectDiskLight::sample_as(const View& from, const Vec2f& u) const {
  const auto& [to_center, height, n] = from;
  const bool shows = !kPlain && image_;
  const bool disk = !kPlain && disk_;
  const std::optional<BilinearDensity> corners = corner_irradiances(from);
  Vec3d wi(0, 0, 0);
  double distance = 0, pdf = 0;
  if (!corners && (kPlain || !is_sampled_by_area(to_center, height))) {
    const SphericalRectangle seen = view_from(to_center, height);
    if (seen.solid_angle() > 0) {
      const Vec3d direction = seen.sample(u);
      wi = x_ * direction.x + y_ * direction.y - n_ * direction.z;
      distance = height / direction.z;
      pdf = 1 / seen.solid_angle();
      if (disk && !place_of(wi * distance - to_center)) return std::nullopt;
    }
  }
  LightImage::Look look{radiance_, 1};
  if (!(pdf > 0)) {
    Place at{2.0 * u.x - 1, 2.0 * u.y - 1};
    if (corners) {
      const Vec2f drawn = corners->sample(u);
      look.density = corners->pdf(drawn);
      at = {2.0 * drawn.x - 1, 2.0 * drawn.y - 1};
    } else if (disk) {
      const Vec2f drawn = sample_concentric_disk(u);
      at = {drawn.x, drawn.y};
    } else if (shows) {
      const LightImage::Place place = image_->sample(u);
      look = image_->look(place, image_scale_);
      at = {1 - 2 * place.u, 1 - 2 * place.v};
    }
    const Vec3d to_light = to_center + x_ * (half_width_ * at.x) + y_ * (half_height_ * at.y);
    distance = length(to_light);
    pdf = pdf_by_area(look.density, distance, height);
    wi = to_light * (1 / distance);
  }
  LightSample s;
  s.wi = to_float(wi);
  s.distance = static_cast<float>(distance);
  s.radiance = kPlain ? radiance_ : shaped(look.radiance, shaping_, -wi);
  s.pdf = static_cast<float>(pdf);
  if (!(s.pdf > 0) || !std::isfinite(s.pdf)) return std::nullopt;
  if (!(s.distance > 0) || !std::isfinite(s.distance)) return std::nullopt;
  if (!kPlain && is_black(s.radiance)) return std::nullopt;
  return s;
}

double RectDiskLight::pdf_of(const View& from, const Place& place, double density, double distance) const {
  if (const auto corners = corner_irradiances(from)) {
    const auto in_square = [](double x) { return static_cast<float>(0.5 + 0.5 * x); };
    return pdf_by_area(corners->pdf({in_square(place.x), in_square(place.y)}), distance, from.height);
  }
  const double angle = solid_angle(from.to_center, from.height);
  return angle > 0 ? 1 / angle : pdf_by_area(density, distance, from.height);
}

std::optional<LightHit> RectDiskLight::intersect(const Ray& ray, const Vec3f& n) const {
  if (is_black(radiance_)) return std::nullopt;
  const Vec3d origin(ray.org), direction(ray.dir);
  const double towards = -dot(direction, n_), height = dot(origin - center_, n_);
  if (!(towards > 0) || !(height > 0)) return std::nullopt;
  const double t = height / towards;
  const auto place = place_of(origin - center_ + direction * t);
  if (!place) return std::nullopt;
  const double speed = length(direction), distance = t * speed;
  LightHit hit;
  hit.t = static_cast<float>(t);
  const LightImage::Look look =
      image_ ? image_->look(place->image_place(), image_scale_) : LightImage::Look{radiance_, 1};
  hit.radiance = shaped(look.radiance, shaping_, direction * (-1 / speed));
  hit.pdf = static_cast<float>(pdf_of({center_ - origin, height, n}, *place, look.density, distance));
  if (!(hit.t > 0) || !std::isfinite(hit.t) || !(hit.pdf > 0) || !std::isfinite(hit.pdf)) return std::nullopt;
  if (is_black(hit.radiance)) return std::nullopt;
  return hit;
}

bool RectDiskLight::is_below(const Vec3f& p, const Vec3f& n) const {
  const Vec3d d = center_ - Vec3d(p), normal(n);
  return is_wholly_below(dot(d, normal),
                         half_width_ * std::abs(dot(x_, normal)) + half_height_ * std::abs(dot(y_, normal)),
                         std::abs(d.x) + std::abs(d.y) + std::abs(d.z));
}

// Irradiance from a disk of the same area on its axis at the distance of the centre, L A / (d^2 + A / pi), times the
// cosine at the light. The cosine is softened by the light's size: near the plane, the nearest part of the rectangle is
// still overhead.
double RectDiskLight::importance(const Vec3f& p) const {
  const Vec3d d = center_ - Vec3d(p);
  const double z = -dot(d, n_);
  if (!(z > 0)) return 0;
  const double d2 = dot(d, d), size = half_width_ + half_height_;
  const double cosine = (z + size) / (std::sqrt(d2) + size);
  const double spot = shaping_ ? shaping_->largest(-d * (1 / std::sqrt(d2)), size / std::sqrt(d2)) : 1;
  return representable_importance(radiance_, spot * area_ * cosine / (d2 + area_ * static_cast<double>(kInvPi)));
}

LightExtent RectDiskLight::extent() const {
  LightExtent extent{{}, representable_importance(radiance_, area_)};
  for (const double x : {-half_width_, half_width_})
    for (const double y : {-half_height_, half_height_}) extent.box.extend(center_ + x_ * x + y_ * y);
  extent.axis = n_;
  extent.normals_angle = 0;
  return extent;
}

}  // namespace alabaster
