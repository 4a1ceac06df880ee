#include "core/light/mesh_light.h"

#include <algorithm>

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

// By area times luminance.
void MeshLight::Emitter::measure(const CancelToken& cancel) {
  std::vector<double> powers;
  powers.reserve(triangles.size());
  double largest = 0;
  BoundsDouble bounds;
  for (Triangle& t : triangles) {
    cancel.check();
    t.radiance = finite_or_black(t.radiance, 1);
    const double area = 0.5 * length(area_vector(t));
    const double emitted = std::isfinite(area) ? area * static_cast<double>(luminance(t.radiance)) : 0;
    powers.push_back(emitted);
    largest = std::max(largest, emitted);
    power += emitted;
    if (emitted > 0)
      for (const Vec3f& p : {t.p0, t.p1, t.p2}) bounds.extend(Vec3d(p));
  }
  if (power > 0) {
    const Vec3d diagonal = bounds.extent();
    center = bounds.lower + diagonal * 0.5;
    squared_radius = 0.25 * dot(diagonal, diagonal);
  }
  std::vector<float> weights;
  weights.reserve(powers.size());
  for (const double emitted : powers) {
    cancel.check();
    weights.push_back(largest > 0 ? static_cast<float>(emitted / largest) : 0.0f);
  }
  distribution = Distribution1D(weights, cancel);
}

void MeshLight::Emitter::index(const std::vector<uint32_t>& ids, const CancelToken& cancel) {
  const size_t known = std::min(ids.size(), triangles.size());
  if (known > 0) index_of_triangle.resize(*std::max_element(ids.begin(), ids.end()) + size_t(1), ~0u);
  for (size_t i = 0; i < known; ++i) {
    cancel.check();
    index_of_triangle[ids[i]] = static_cast<uint32_t>(i);
  }
}

MeshLight::MeshLight(uint32_t instance, std::vector<Triangle> triangles, const std::vector<uint32_t>& triangle_ids,
                     Emission emission, const CancelToken& cancel)
    : instance_(instance) {
  auto emitter = std::make_shared<Emitter>();
  emitter->triangles = std::move(triangles);
  emitter->emission = std::move(emission);
  emitter->triangle_ids = triangle_ids;
  emitter->measure(cancel);
  emitter->index(triangle_ids, cancel);
  emitter_ = std::move(emitter);
}

// Area to solid angle: P / A * d^2 / |cos|; the area vector n has length 2A, so A |cos| = |n . wi| / 2.
float MeshLight::Emitter::pdf(size_t entry, const Vec3d& wi, double distance) const {
  const double facing = 0.5 * std::abs(dot(area_vector(triangles[entry]), wi));
  const auto pdf =
      static_cast<float>(static_cast<double>(distribution.probability(entry)) * distance * distance / facing);
  return facing > 0 && std::isfinite(pdf) ? pdf : 0;
}

std::optional<LightSample> MeshLight::sample(const Vec3f& p, const Vec2f& u, const Vec3f& /*n*/) const {
  const Emitter& emitter = *emitter_;
  if (!(emitter.power > 0)) return std::nullopt;
  const auto chosen = emitter.distribution.sample(u.x);
  const Triangle& t = emitter.triangles[chosen.index];
  const Vec2f b = sample_uniform_triangle({chosen.remapped, u.y});
  const double b0 = b.x, b1 = b.y;
  const Vec3d to_light = Vec3d(t.p0) * b0 + Vec3d(t.p1) * b1 + Vec3d(t.p2) * (1 - b0 - b1) - Vec3d(p);
  const double distance = length(to_light);
  if (!(distance > 0)) return std::nullopt;
  const Vec3d wi = to_light * (1 / distance);
  LightSample s;
  s.on_mesh = true;
  s.instance = instance_;
  s.triangle = emitter.triangle_ids[chosen.index];
  s.place = {b.y, 1 - b.x - b.y};
  s.wi = to_float(wi);
  s.distance = static_cast<float>(distance);
  if (t.one_sided && dot(area_vector(t), wi) > 0) return std::nullopt;
  s.radiance = t.radiance;
  if (emitter.emission) s.radiance = finite_or_black(emitter.emission(s.triangle, s.place), 1);
  if (is_black(s.radiance)) return std::nullopt;
  s.pdf = emitter.pdf(chosen.index, wi, distance);
  if (!(s.pdf > 0) || !(s.distance > 0) || !std::isfinite(s.distance)) return std::nullopt;
  return s;
}

float MeshLight::pdf(uint32_t triangle_id, const Vec3f& wi, float t) const {
  const Emitter& emitter = *emitter_;
  if (!(emitter.power > 0) || triangle_id >= emitter.index_of_triangle.size()) return 0;
  const uint32_t entry = emitter.index_of_triangle[triangle_id];
  return entry == ~0u ? 0 : emitter.pdf(entry, Vec3d(wi), t);
}

size_t MeshLight::memory_bytes() const {
  const Emitter& e = *emitter_;
  return e.triangles.capacity() * sizeof(Triangle) +
         (e.index_of_triangle.capacity() + e.triangle_ids.capacity()) * sizeof(uint32_t) +
         e.distribution.memory_bytes();
}

// A triangle, its id and a copy of it, its power and weight, its cumulative number and its share of the guide. The
// index is of the mesh.
size_t MeshLight::build_bytes(size_t triangles, size_t of_mesh) {
  constexpr size_t kEach = sizeof(Triangle) + 2 * sizeof(uint32_t) + sizeof(double) + 2 * sizeof(float) + 2;
  return (triangles + 1) * kEach + of_mesh * sizeof(uint32_t);
}

void MeshLight::hold(MemoryReservation memory) {
  memory.shrink(memory_bytes());
  memory_ = std::make_shared<const MemoryReservation>(std::move(memory));
}

// The whole power at distance sqrt(d^2 + r^2), d to the centre and r the radius of the bounding sphere, with the mean
// |cos| of 1/2 of triangles that face anywhere.
double MeshLight::importance(const Vec3f& p) const {
  const Emitter& e = *emitter_;
  const Vec3d d = e.center - Vec3d(p);
  return e.power > 0 ? representable_importance(Rgb(1.0f), 0.5 * e.power / (dot(d, d) + e.squared_radius)) : 0;
}

LightExtent MeshLight::extent() const {
  const Emitter& e = *emitter_;
  const Vec3d r(std::sqrt(e.squared_radius / 3));
  return {{e.center - r, e.center + r}, representable_importance(Rgb(1.0f), 0.5 * e.power)};
}

}  // namespace alabaster
