#include "core/integrator/coincident_surfaces.h"

#include <algorithm>

#include "core/integrator/interface.h"
#include "core/integrator/see_through.h"

namespace alabaster {
namespace {

// Stops at opaque surfaces that the path's ray would stop at, and notes those of closed clear bodies other than `own`,
// one of each body.
class CoincidentSurfaces final : public HitFilter {
 public:
  static constexpr uint32_t kMost = 32;  // bodies whose walls lie within rounding of one point

  CoincidentSurfaces(const SceneSnapshot& scene, const Ray& ray, uint32_t own, const StochasticStop& path_stops)
      : scene_(scene), ray_(ray), own_(own), path_stops_(path_stops) {}
  bool stops(const TriangleHit& hit) const noexcept override {
    const Instance& instance = scene_.instance(hit.instance);
    const DisneyMaterial& material = instance.material(hit.triangle);
    if (!material.transmits()) return hit.instance != own_ && path_stops_.stops(hit);
    const auto end = found_.begin() + count_;
    const bool known = std::any_of(found_.begin(), end, [&](const auto& h) { return h.instance == hit.instance; });
    if (known || hit.instance == own_ || count_ == kMost || !instance.prototype->mesh.closed) return false;
    if (material.constants.thin) return false;
    if (!(coverage_at(scene_, ray_.dir, hit, nullptr) < 1)) found_[count_++] = hit;
    return false;
  }
  std::vector<TriangleHit> sorted() const {
    std::vector<TriangleHit> all(found_.begin(), found_.begin() + count_);
    std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.instance < b.instance; });
    return all;
  }

 private:
  const SceneSnapshot& scene_;
  const Ray& ray_;
  const uint32_t own_;
  const StochasticStop& path_stops_;
  mutable std::array<TriangleHit, kMost> found_;
  mutable uint32_t count_ = 0;
};

// The clear surface of the highest priority. Null: that of `v`, or light walks in one of the bodies with nothing that
// stands in it: a ray in its medium must meet its own wall.
const TriangleHit* first_of(const PathContext& context, const Ray& ray, const Vertex& v,
                            const std::vector<TriangleHit>& others) {
  const TriangleHit* first = nullptr;
  const Interior own = interior_of(v);
  bool scatters = own.scatters && !own.occupied;
  uint64_t priority = own.priority;
  Vertex on_other;
  for (const TriangleHit& other : others) {
    evaluate_surface(context, ray, other, 0, &on_other);
    const Interior its = interior_of(on_other);
    if (its.priority > priority) first = &other, priority = its.priority;
    scatters = scatters || (its.scatters && !its.occupied);
  }
  return scatters ? nullptr : first;
}

}  // namespace

bool find_coincident_surfaces(const PathContext& context, const PixelSampler& sampler, bool inside, Vertex* v,
                              Path* path) {
  if (!context.scene.clear_meetings.contains(v->hit.p)) [[likely]]
    return false;
  MediumStack* const media = &path->media;
  const Vec3f &near = v->origins[Vertex::kFacet].p, &far = v->origins[Vertex::kFarSide].p;
  const Ray across{near, -v->hit.ng, length(far - near), v->triangle.time};
  const StochasticStop path_stops(context.scene, path->ray.dir, *media, sampler, path->depth);
  const CoincidentSurfaces surfaces(context.scene, across, v->triangle.instance, path_stops);
  ++context.counters.bounce_rays;
  TriangleHit opaque;
  const bool is_on_opaque = context.scene.top->intersect(across, &opaque, &surfaces);
  const std::vector<TriangleHit> hits = surfaces.sorted();
  if (const TriangleHit* const first = is_on_opaque ? &opaque : first_of(context, across, *v, hits)) {
    const float t = v->triangle.t;
    v->triangle = *first;
    v->triangle.t = t;
    return true;
  }
  if (hits.empty()) return false;
  std::vector<Interior> entered;
  Vertex other;
  for (const TriangleHit& hit : hits) {
    evaluate_surface(context, across, hit, 0, &other);
    const bool leaves = is_seen_from_inside(other, *media);
    if (leaves == media->contains(hit.instance)) {
      if (!leaves) entered.push_back(interior_of(other));
      continue;
    }
    if (leaves)
      media->enter(interior_of(other));
    else
      media->leave(hit.instance), entered.push_back(interior_of(other));
  }
  v->beyond = *media;
  for (const TriangleHit& hit : hits) v->beyond->leave(hit.instance);
  cross_interface(*v, inside, &*v->beyond);
  for (const Interior& interior : entered) v->beyond->enter(interior);
  return false;
}

}  // namespace alabaster
