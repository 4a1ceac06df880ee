#include "core/light/mesh_light.h"

#include "core/math/bounds.h"
#include "core/sampling/warp.h"

namespace alabaster {
namespace {

// Twice the area, along the normal.
Vec3d area_vector(const MeshLight::Triangle& t) {
  const Vec3d p0(t.p0);
  return cross(Vec3d(t.p1) - p0, Vec3d(t.p2) - p0);
}

}  // namespace

MeshLight::MeshLight(uint32_t instance, std::vector<Triangle> triangles, const std::vector<uint32_t>& triangle_ids,
                     Emission emission)
    : instance_(instance), triangles_(std::move(triangles)), emission_(std::move(emission)) {
  if (emission_) triangle_ids_ = triangle_ids;
  std::vector<double> powers(triangles_.size());
  double largest = 0;
  BoundsDouble bounds;
  for (size_t i = 0; i < triangles_.size(); ++i) {
    Triangle& t = triangles_[i];
    t.radiance = finite_or_black(t.radiance, 1);
    const double area = 0.5 * length(area_vector(t));
    powers[i] = std::isfinite(area) ? area * static_cast<double>(luminance(t.radiance)) : 0;
    largest = std::max(largest, powers[i]);
    power_ += powers[i];
    if (powers[i] > 0)
      for (const Vec3f& p : {t.p0, t.p1, t.p2}) bounds.extend(Vec3d(p));
  }
  if (power_ > 0) {
    const Vec3d diagonal = bounds.extent();
    center_ = bounds.lower + diagonal * 0.5;
    squared_radius_ = 0.25 * dot(diagonal, diagonal);
  }
  std::vector<float> weights(triangles_.size(), 0.0f);
  for (size_t i = 0; i < weights.size() && largest > 0; ++i) weights[i] = static_cast<float>(powers[i] / largest);
  distribution_ = Distribution1D(weights);
  const size_t known = std::min(triangle_ids.size(), triangles_.size());
  for (size_t i = 0; i < known; ++i) {
    if (triangle_ids[i] >= index_of_triangle_.size()) index_of_triangle_.resize(triangle_ids[i] + size_t(1), ~0u);
    index_of_triangle_[triangle_ids[i]] = static_cast<uint32_t>(i);
  }
}

// Area to solid angle: P / A * d^2 / |cos|; the area vector n has length 2A, so A |cos| = |n . wi| / 2.
float MeshLight::pdf_of_entry(size_t entry, const Vec3d& wi, double distance) const {
  const double facing = 0.5 * std::abs(dot(area_vector(triangles_[entry]), wi));
  const auto pdf =
      static_cast<float>(static_cast<double>(distribution_.probability(entry)) * distance * distance / facing);
  return facing > 0 && std::isfinite(pdf) ? pdf : 0;
}

std::optional<LightSample> MeshLight::sample(const Vec3f& p, const Vec2f& u) const {
  if (!(power_ > 0)) return std::nullopt;
  const auto chosen = distribution_.sample(u.x);
  const Triangle& t = triangles_[chosen.index];
  const Vec2f b = sample_uniform_triangle({chosen.remapped, u.y});
  const double b0 = b.x, b1 = b.y;
  const Vec3d to_light = Vec3d(t.p0) * b0 + Vec3d(t.p1) * b1 + Vec3d(t.p2) * (1 - b0 - b1) - Vec3d(p);
  const double distance = length(to_light);
  if (!(distance > 0)) return std::nullopt;
  const Vec3d wi = to_light * (1 / distance);
  LightSample s;
  s.on_mesh = true;
  s.wi = to_float(wi);
  s.distance = static_cast<float>(distance);
  if (t.one_sided && dot(area_vector(t), wi) > 0) return std::nullopt;
  s.radiance =
      emission_ ? finite_or_black(emission_(triangle_ids_[chosen.index], {b.y, 1 - b.x - b.y}), 1) : t.radiance;
  if (is_black(s.radiance)) return std::nullopt;
  s.pdf = pdf_of_entry(chosen.index, wi, distance);
  if (!(s.pdf > 0) || !(s.distance > 0) || !std::isfinite(s.distance)) return std::nullopt;
  return s;
}

float MeshLight::pdf(uint32_t triangle_id, const Vec3f& wi, float t) const {
  if (!(power_ > 0) || triangle_id >= index_of_triangle_.size()) return 0;
  const uint32_t entry = index_of_triangle_[triangle_id];
  return entry == ~0u ? 0 : pdf_of_entry(entry, Vec3d(wi), t);
}

size_t MeshLight::memory_bytes() const {
  return triangles_.capacity() * sizeof(Triangle) +
         (index_of_triangle_.capacity() + triangle_ids_.capacity()) * sizeof(uint32_t) + distribution_.memory_bytes();
}

// The whole power at distance sqrt(d^2 + r^2), d to the centre and r the radius of the bounding sphere, with the mean
// |cos| of 1/2 of triangles that face anywhere.
double MeshLight::importance(const Vec3f& p) const {
  const Vec3d d = center_ - Vec3d(p);
  return power_ > 0 ? representable_importance(Rgb(1.0f), 0.5 * power_ / (dot(d, d) + squared_radius_)) : 0;
}

LightExtent MeshLight::extent() const {
  const Vec3d r(std::sqrt(squared_radius_ / 3));
  return {{center_ - r, center_ + r}, representable_importance(Rgb(1.0f), 0.5 * power_)};
}

}  // namespace alabaster
