#include "core/integrator/coincident_surfaces.h"

#include <algorithm>
#include <limits>
#include <new>
#include <vector>

#include "core/integrator/interface.h"
#include "core/integrator/see_through.h"

namespace alabaster {
namespace {

// Stops at opaque surfaces of bodies other than `own` that the path's ray would stop at, and notes those of closed
// clear ones, one of each body.
class CoincidentSurfaces final : public HitFilter {
 public:
  CoincidentSurfaces(const SceneSnapshot& scene, uint32_t own, const StochasticStop& path_stops)
      : scene_(scene), own_(own), path_stops_(path_stops) {}
  bool stops(const TriangleHit& hit) const noexcept override {
    const Instance& instance = scene_.instance(hit.instance);
    const DisneyMaterial& material = instance.material(hit.triangle);
    if (hit.instance == own_) return false;
    if (material.transmits() && (!instance.prototype->mesh.closed || material.constants.thin)) return false;
    if (!path_stops_.stops(hit)) return false;
    if (!material.transmits()) return true;
    if (std::any_of(found_.begin(), found_.end(), [&](const auto& h) { return h.instance == hit.instance; }))
      return false;
    try {
      found_.push_back(hit);
    } catch (const std::bad_alloc&) {  // Embree's callbacks let none through; the path will ask for memory as well
    }
    return false;
  }
  std::vector<TriangleHit> sorted() const {
    std::vector<TriangleHit> all = found_;
    std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.instance < b.instance; });
    return all;
  }

 private:
  const SceneSnapshot& scene_;
  const uint32_t own_;
  const StochasticStop& path_stops_;
  mutable std::vector<TriangleHit> found_;
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
  const CoincidentSurfaces surfaces(context.scene, v->triangle.instance, path_stops);
  ++context.counters.bounce_rays;
  TriangleHit opaque;
  const bool is_on_opaque = context.scene.top->intersect(across, &opaque, &surfaces);
  const bool passes_holes = path_stops.uncross_holes(&path->air);
  const std::vector<TriangleHit> hits = surfaces.sorted();
  if (const TriangleHit* const first = is_on_opaque ? &opaque : first_of(context, across, *v, hits)) {
    const float t = v->triangle.t;
    v->triangle = *first;
    v->triangle.t = t;
    return true;
  }
  if (passes_holes) {
    v->air_beyond = path->air;
    path_stops.cross_holes(std::numeric_limits<float>::infinity(), &*v->air_beyond);
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
