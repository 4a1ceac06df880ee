#include "core/integrator/boundary.h"

#include <algorithm>
#include <limits>

#include "core/integrator/direct_light.h"
#include "core/integrator/path_record.h"
#include "core/integrator/see_through.h"
#include "core/scene/clear_bodies.h"

namespace alabaster {
namespace {

// True if the vertex is seen from the interior. The winding of a closed mesh that does not wind outward, such as one
// whose faces are all doubled, does not tell; `interiors` do, in which the ray arrives.
bool is_seen_from_inside(const PathVertex& v, const Interiors& interiors) {
  const Mesh& mesh = v.instance->prototype->mesh;
  if (!mesh.outward && mesh.closed) [[unlikely]]
    return interiors.contains(v.triangle.instance);
  return is_behind(*v.instance, v.triangle, -v.hit.ng);
}

// True for a solid that only diffuse light passes.
bool is_index_matched(const PathVertex& v) {
  return !v.material.thin && !(v.instance->material(v.triangle.triangle).constants.spec_trans > 0);
}

Interior interior_of(const PathVertex& v) {
  const DisneyParameters& p = v.material;
  const uint32_t own_number = v.triangle.instance & 0xff;  // alike bodies have different ones
  Interior interior{v.triangle.instance, clear_priority(*v.instance, p.priority) + own_number, p.ior};
  interior.index_matched = is_index_matched(v);
  interior.scatters = p.scatters() && p.metallic < 1;
  // KHR_materials_dispersion: blue's index less red's is (ior - 1) dispersion / 20.
  interior.spread = 0.025f * p.dispersion * (p.ior - 1);
  // Where light scatters inside, walks absorb it.
  if (p.scatters() || !(p.attenuation_distance > 0)) return interior;
  constexpr float kBlackest = 1e-30f;
  for (int c = 0; c < 3; ++c)
    interior.sigma_a[c] = -std::log(std::max(p.attenuation_color[c], kBlackest)) / p.attenuation_distance;
  return interior;
}

// Ray origin on the far side.
Vec3f beyond(const PathVertex& v) {
  return offset_point(v.hit.p, -v.hit.ng, v.hit.offset);
}

// The only channel that carries light; green where there are several.
int channel_of(const Rgb& throughput) {
  if (throughput.g == 0 && throughput.b == 0) return 0;
  return throughput.r == 0 && throughput.g == 0 ? 2 : 1;
}

bool has_several_channels(const Rgb& c) {
  return (c.r != 0) + (c.g != 0) + (c.b != 0) > 1;
}

// Keeps one channel of three, with three times the light.
void choose_channel(float* u, Rgb* throughput) {
  const int chosen = std::min(2, static_cast<int>(3 * *u));
  *u = std::clamp(3 * *u - static_cast<float>(chosen), 0.0f, kOneMinusEpsilon);
  Rgb kept(0.0f);
  kept[chosen] = 3 * (*throughput)[chosen];
  *throughput = kept;
}

void cross_boundary(const PathVertex& v, bool inside, Interiors* interiors) {
  if (v.material.thin) return;
  if (inside)
    interiors->leave(v.triangle.instance);
  else
    interiors->enter(interior_of(v));
}

// The interiors on the other side of the surface.
Interiors interiors_past(const PathVertex& v, Interiors interiors) {
  if (v.past) return *v.past;
  cross_boundary(v, v.boundary.inside, &interiors);
  return interiors;
}

// Factor of what passes the surface, beside the lobes: those of a clear boundary have it.
Rgb passing_factor(const PathVertex& v, const Interiors& from, const Interiors& to) {
  return is_index_matched(v) ? index_factor(from.indices(), to.indices()) : Rgb(1.0f);
}

void pass(const PathContext& context, const PathVertex& v, const Rgb& factor, const Interiors& past, PathState* path) {
  path->throughput *= factor;
  path->interiors = past;
  if (!path->hollows.empty()) path->hollows.leave(hollow_of(context.scene, v.triangle.instance));
}

// The side of the surface that a direction leaves to: light that passes must do so by the lobe, by the interpolated
// normal, which a normal map tilts, and by the facet.
enum class Side { near, far, neither };
Side side_of(const PathVertex& v, const DisneyTransmissiveBsdf& bsdf, const Vec3f& wi_local, const Vec3f& wi) {
  if (bsdf.reflects_to(wi_local) && v.is_above_surface(wi)) return Side::near;
  return wi_local.z < 0 && dot(wi, v.departure.n) < 0 && dot(wi, v.hit.ng) < 0 ? Side::far : Side::neither;
}

// Passes all surfaces but those of clear bodies.
class ClearSurfaces final : public HitFilter {
 public:
  explicit ClearSurfaces(const SceneSnapshot& scene) : scene_(scene) {}
  bool stops(const TriangleHit& hit) const noexcept override {
    const DisneyMaterial& material = scene_.instance(hit.instance).material(hit.triangle);
    return material.transmits() && !material.constants.thin;
  }

 private:
  const SceneSnapshot& scene_;
};

// Stops at opaque surfaces that the path's ray would stop at, and notes those of closed clear bodies other than `own`,
// one of each body.
class CoincidentSurfaces final : public HitFilter {
 public:
  static constexpr uint32_t kMost = Interiors::kMost;

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

// The clear surface of the highest priority. Null: that of `v`, or light walks in one of the bodies: a ray in its
// medium must meet its own wall.
const TriangleHit* first_of(const PathContext& context, const Ray& ray, const PathVertex& v,
                            const std::vector<TriangleHit>& others) {
  const TriangleHit* first = nullptr;
  const Interior own = interior_of(v);
  bool scatters = own.scatters;
  uint32_t priority = own.priority;
  for (const TriangleHit& other : others) {
    const Interior its = interior_of(make_vertex(context, ray, other));
    if (its.priority > priority) first = &other, priority = its.priority;
    scatters = scatters || its.scatters;
  }
  return scatters ? nullptr : first;
}

// Finds the surfaces of other bodies between the two origins of rays that leave this surface: the next ray would miss
// them. Sets v->past if clear ones do. The path's interiors, on the near side, then agree with them. True: v->triangle
// is now on one that takes this one's place.
bool find_coincident(const PathContext& context, const PixelSampler& sampler, bool inside, PathVertex* v,
                     PathState* path) {
  if (!context.scene.clear_meetings.contains(v->hit.p)) [[likely]]
    return false;
  Interiors* const interiors = &path->interiors;
  const Vec3f& near = v->departure.flat;
  const Ray across{near, -v->hit.ng, length(beyond(*v) - near), v->triangle.time};
  const StochasticStop path_stops(context.scene, path->ray.dir, *interiors, sampler, path->depth);
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
  for (const TriangleHit& hit : hits) {
    const PathVertex other = make_vertex(context, across, hit);
    const bool leaves = is_seen_from_inside(other, *interiors);
    if (leaves == interiors->contains(hit.instance)) {
      if (!leaves) entered.push_back(interior_of(other));
      continue;
    }
    if (leaves)
      interiors->enter(interior_of(other));
    else
      interiors->leave(hit.instance), entered.push_back(interior_of(other));
  }
  v->past = *interiors;
  for (const TriangleHit& hit : hits) v->past->leave(hit.instance);
  cross_boundary(*v, inside, &*v->past);
  for (const Interior& interior : entered) v->past->enter(interior);
  return false;
}

bool is_same(const Interior* a, const Interior* b) {
  return a && b ? a->instance == b->instance : a == b;
}

}  // namespace

Meeting meet_boundary(const PathContext& context, const PixelSampler& sampler, PathVertex* v, PathState* path,
                      float* u) {
  const DisneyParameters& p = v->material;
  Interiors& interiors = path->interiors;
  const uint32_t instance = v->triangle.instance;
  if (p.thin) {
    v->boundary = {p.ior / interiors.index(), false};
    return Meeting::boundary;
  }
  const bool inside = is_seen_from_inside(*v, interiors);
  const Interior own = interior_of(*v);
  // A surface that is left without having been entered belongs to an open mesh.
  if (inside && !interiors.contains(instance)) interiors.enter(own);
  if (find_coincident(context, sampler, inside, v, path)) return Meeting::other;
  // The media on this body's side and on the other one.
  const Interior* within = &own;
  const Interior* other = inside ? interiors.current_without(instance) : interiors.current();
  bool is_there = inside ? interiors.current()->instance == instance : !other || other->priority <= own.priority;
  if (v->past) [[unlikely]] {
    within = inside ? interiors.current() : v->past->current();
    other = inside ? v->past->current() : interiors.current();
    is_there = !is_same(within, other);
  }
  if (!is_there) {
    if (v->past)
      interiors = *v->past;
    else
      cross_boundary(*v, inside, &interiors);
    path->go_on(beyond(*v), path->ray.dir);
    path->scatter_pdf = std::numeric_limits<float>::infinity();
    return Meeting::nothing;
  }
  const auto index = [](const Interior* at, int channel) { return at ? at->index(channel) : 1; };
  const bool disperses = (within && within->spread > 0) || (other && other->spread > 0);
  if (disperses && p.spec_trans > 0 && has_several_channels(path->throughput)) choose_channel(u, &path->throughput);
  const int channel = channel_of(path->throughput);
  const float eta = index(within, channel) / index(other, channel);
  v->boundary = {inside ? 1 / eta : eta, inside, !v->instance->prototype->mesh.closed};
  return Meeting::boundary;
}

std::optional<Lobe> scatter_at_boundary(const PathContext& context, const PathVertex& v, const VertexNumbers& numbers,
                                        PathState* path, LayerSplit* split) {
  const bool splits = split && path->depth == 0;
  if (splits) split->emission = path->radiance;
  PathRecord* const record = context.record;
  const DisneyTransmissiveBsdf bsdf(v.material, v.frame.to_local(-path->ray.dir), v.boundary, context.settings.energy);

  const Interiors interiors_beyond = interiors_past(v, path->interiors);
  const Rgb passing = passing_factor(v, path->interiors, interiors_beyond);
  // Sample the lights, on each side for the directions that leave there.
  path->search = v.material.scatters() ? ConstantDomes::sampled : ConstantDomes::bsdf_sampling_only;
  path->lights = &context.scene.lights_of(*v.instance);
  const auto sample_lights = [&](const Departure& from, Side side) {
    const auto lobes = [&](const Vec3f& wi_world) -> ScatterValue {
      const Vec3f wi = v.frame.to_local(wi_world);
      if (side_of(v, bsdf, wi, wi_world) != side) return {};
      Rgb specular;
      const BsdfValue value = bsdf.evaluate(wi, splits ? &specular : nullptr);
      const Rgb f_cos = (side == Side::far ? value.f * passing : value.f) * std::abs(wi.z);
      if (record) record->sample_light(wi_world, f_cos, value.pdf);
      return {f_cos, value.pdf, splits ? share_of(specular, value.f) : Rgb(0.0f)};
    };
    const Interiors& interiors = side == Side::far ? interiors_beyond : path->interiors;
    for_direct_light(context, from, {*path->lights, numbers.light, path->search, &interiors}, lobes,
                     [&](const ScatterValue& value, const Rgb& arriving, LightWeight weight) {
                       const Rgb light = path->throughput * arriving * interiors.transmittance(weight.distance);
                       path->radiance += light;
                       if (record) record->light_arrives(light, weight);
                       if (splits) split->add_local(light, value.specular_share);
                     });
  };
  sample_lights(v.departure, Side::near);
  if (bsdf.scatters_beyond()) sample_lights({.flat = beyond(v), .ng = -v.hit.ng, .n = -v.frame.n}, Side::far);
  if (splits) split->gathered = path->radiance, split->scattered = true;

  // Sample a lobe and a direction.
  Rgb specular;
  const auto& u = numbers.bsdf;
  const auto sample = bsdf.sample(u[0], {u[1], u[2]}, splits ? &specular : nullptr);
  if (record && sample) record->sample_lobe(lobe_name(sample->lobe), sample->f, sample->pdf);
  const Vec3f wi = sample ? v.frame.to_world(sample->wi) : Vec3f(0, 0, 0);
  const bool leaves = sample && sample->lobe != Lobe::subsurface;
  const Side side = !leaves ? Side::neither : side_of(v, bsdf, sample->wi, wi);
  if (!sample || (leaves && side == Side::neither)) {
    if (record) record->end("no direction was sampled");
    return std::nullopt;
  }
  const bool leaves_straight = sample->lobe == Lobe::straight, discrete = !leaves || leaves_straight;
  path->throughput *= sample->f * ((discrete ? 1 : std::abs(sample->wi.z)) / sample->pdf);
  if (!leaves) return sample->lobe;
  if (splits) {
    split->specular_share = sample->lobe == Lobe::straight ? Rgb(1.0f) : share_of(specular, sample->f);
    split->went_on = true;
  }
  path->scatter_pdf = discrete ? std::numeric_limits<float>::infinity() : sample->pdf;
  const bool far = side == Side::far;
  if (far) pass(context, v, passing, interiors_beyond, path);
  path->go_on(far ? beyond(v) : origin_of(context, v.departure, wi), leaves_straight ? path->ray.dir : wi);
  return sample->lobe;
}

Interiors interiors_at(const PathContext& context, Ray ray, Seeker seeker) {
  const ClearSurfaces filter(context.scene);
  const bool is_camera = seeker == Seeker::camera;
  Interiors entered, about;
  std::array<Interior, Interiors::kMost> found;
  uint32_t count = 0;
  constexpr int kMostSurfaces = 256;
  TriangleHit hit;
  ray.tmax = std::numeric_limits<float>::infinity();
  for (int i = 0; i < kMostSurfaces; ++i) {
    ++(is_camera ? context.counters.camera_rays : context.counters.bounce_rays);
    if (!context.scene.top->intersect(ray, &hit, &filter)) break;
    const PathVertex v = make_vertex(context, ray, hit);
    ray.org = beyond(v);
    const bool inside = is_seen_from_inside(v, entered);
    if (!v.material.transmits() || (is_camera && v.instance->options.camera_cull == CameraCull::all)) continue;
    // The way out of this body is not seen: the camera's ray would carry its interior on.
    if (is_camera && inside && is_culled(*v.instance, hit, ray.dir)) continue;
    if (!inside)
      entered.enter(interior_of(v));
    else if (entered.contains(hit.instance))
      entered.leave(hit.instance);
    else if (count < found.size())
      found[count++] = interior_of(v);
  }
  // The surface that is left last was entered first.
  while (count > 0) about.enter(found[--count]);
  return about;
}

}  // namespace alabaster
