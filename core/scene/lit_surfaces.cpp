#include "core/scene/lit_surfaces.h"

#include <cmath>
#include <utility>

#include "core/geometry/surface_hit.h"
#include "core/sampling/pixel_sampler.h"
#include "core/sampling/warp.h"
#include "core/subsurface/body.h"

namespace alabaster {
namespace {

// Points that are looked at on one body, at most; on all bodies together; and the fewest that are worth looking at.
constexpr size_t kMostPoints = 128, kAllPoints = 8192, kFewestPoints = 64;
// Directions from each: fewer would take the noise of a dome for darkness.
constexpr int kDirections = 8;

// Numbers spread over the unit cube by Roberts' R3 lattice, shifted at random.
std::array<float, 4> spread(int i, const Vec3f& shift) {
  const auto at = [i](float start, double step) {
    const double x = static_cast<double>(start) + i * step;
    return std::min(static_cast<float>(x - std::floor(x)), kOneMinusEpsilon);
  };
  return {at(shift.x, 0.8191725134), at(shift.y, 0.6710436067), at(shift.z, 0.5497004779), 0};
}

// The time of the shutter at which moving things are looked at: only noise depends on it.
constexpr float kTime = 0.5f;

// The surfaces that cast shadows of a light with a shadow link.
class LinkedSurfaces final : public HitFilter {
 public:
  LinkedSurfaces(const SceneSnapshot& scene, uint32_t shadow_link) : scene_(scene), shadow_link_(shadow_link) {}
  bool stops(const TriangleHit& hit) const noexcept override {
    return scene_.casts_shadow(scene_.instance(hit.instance), shadow_link_);
  }

 private:
  const SceneSnapshot& scene_;
  const uint32_t shadow_link_;
};

float irradiance_at(const SceneSnapshot& snapshot, const Instance& instance, const SurfaceHit& hit, Rng& rng) {
  const Vec3f p = offset_point(hit.p, hit.ng, hit.offset);
  const Vec3f shift(rng.uniform(), rng.uniform(), rng.uniform());
  float sum = 0;
  const LightSet& lights = snapshot.lights_of(instance);
  const LightSampleContext context{ConstantDomes::sampled, hit.ng, kTime};
  for (int i = 0; i < kDirections; ++i)
    for (size_t k = 0; k < lights.draws(context); ++k) {
      const auto light = lights.draw(k, p, {hit.ng, hit.ng}, spread(i, shift), context);
      const float cosine = light ? dot(light->wi, hit.ng) : 0;
      if (!(cosine > 0)) continue;
      const LinkedSurfaces linked(snapshot, light->shadow_link);
      if (snapshot.top->occluded({p, light->wi, light->shadow_length(), kTime}, light->shadow_link ? &linked : nullptr))
        continue;
      const float diffuse = light->scales ? light->scales->diffuse : 1.0f;
      sum += diffuse * luminance(light->radiance) * cosine / light->pdf;
    }
  return std::isfinite(sum) ? sum : 0;
}

// A point of a triangle, which stands for `of_each` triangles of this area.
LitPoint light_on(const SceneSnapshot& snapshot, const Instance& instance, uint32_t triangle, float of_each, Rng rng) {
  const Mesh& mesh = instance.prototype->mesh;
  const Vec2f b = sample_uniform_triangle({rng.uniform(), rng.uniform()});
  TriangleHit at;
  at.u = b.x, at.v = b.y, at.triangle = triangle;
  if (!instance.is_still()) at.time = kTime;
  std::optional<Placement> moved;
  const Placement& placement = instance.at(at, &moved);
  const SurfaceHit hit = surface_hit(mesh, at, placement.object_to_world, placement.world_to_object);
  const std::array<Vec3f, 3> corners = mesh.corners_at(triangle, at.time);
  const auto corner = [&](size_t c) { return placement.object_to_world.point(corners[c]); };
  const float area = 0.5f * length(cross(corner(1) - corner(0), corner(2) - corner(0))) * of_each;
  return {hit.p, -hit.ng, irradiance_at(snapshot, instance, hit, rng), area};
}

// Points on every so many triangles, over the members as if they were one mesh.
std::vector<LitPoint> lit_points(const SceneSnapshot& snapshot, const SubsurfaceBody& body, size_t count) {
  size_t triangles = 0;
  for (const auto& member : body.members) triangles += member.mesh->triangles.size();
  std::vector<LitPoint> points(count);
  const float of_each = static_cast<float>(triangles) / static_cast<float>(count);
  for (size_t i = 0; i < count; ++i) {
    size_t triangle = (2 * i + 1) * triangles / (2 * count);
    auto member = body.members.begin();
    for (; triangle >= member->mesh->triangles.size(); ++member) triangle -= member->mesh->triangles.size();
    points[i] =
        light_on(snapshot, snapshot.instances[member->instance], static_cast<uint32_t>(triangle), of_each, Rng(0, i));
  }
  return points;
}

// The body of a snapshot with the same members, or null.
const SubsurfaceBody* find_same(const SceneSnapshot* snapshot, const SubsurfaceBody& body) {
  if (!snapshot) return nullptr;
  const SubsurfaceBody* const other = snapshot->instances[body.members.front().instance].body;
  const auto same = [](const auto& a, const auto& b) { return a.instance == b.instance; };
  const bool found =
      other && std::equal(body.members.begin(), body.members.end(), other->members.begin(), other->members.end(), same);
  return found ? other : nullptr;
}

}  // namespace

void plan_lit_surfaces(const SceneSnapshot* alike, SceneSnapshot* snapshot) {
  if (snapshot->bodies.empty()) return;
  // The number of points depends on that of the bodies.
  if (alike && alike->bodies.size() != snapshot->bodies.size()) alike = nullptr;
  const size_t points = std::min(kMostPoints, kAllPoints / snapshot->bodies.size());
  if (points < kFewestPoints) return;
  for (auto& body : snapshot->bodies) {
    if (body->members.front().array) continue;  // light falls on each instance from elsewhere
    const SubsurfaceBody* const same = find_same(alike, *body);
    if (same && same->lit && same->lit->is_found())
      body->lit = same->lit;
    else
      body->lit = std::make_shared<LazyLitSurface>([scene = std::as_const(snapshot), lone = body.get(), points] {
        return LitSurface::choose(lit_points(*scene, *lone, points));
      });
    snapshot->memory_bytes += sizeof(LazyLitSurface);
  }
}

}  // namespace alabaster
