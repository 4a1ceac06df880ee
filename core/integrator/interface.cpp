#include "core/integrator/interface.h"

#include <algorithm>
#include <limits>

#include "core/integrator/coincident_surfaces.h"
#include "core/integrator/see_through.h"
#include "core/scene/clear_bodies.h"
#include "core/subsurface/body.h"

namespace alabaster {
namespace {

// True for a solid that only diffuse light passes.
bool is_index_matched(const Vertex& v) {
  return !v.material.thin && !(v.instance->material(v.triangle.triangle).constants.spec_trans > 0);
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

// The first of the materials that is the boundary of a solid; null: there is none.
const DisneyMaterial* clear_material(const Instance& instance) {
  for (const DisneyMaterial* material : instance.materials)
    if (material->transmits() && !material->constants.thin) return material;
  return nullptr;
}

// Passes all surfaces but those of clear bodies, which opaque faces of their meshes are, too.
class ClearSurfaces final : public HitFilter {
 public:
  explicit ClearSurfaces(const SceneSnapshot& scene) : scene_(scene) {}
  bool stops(const TriangleHit& hit) const noexcept override {
    const Instance& instance = scene_.instance(hit.instance);
    const DisneyMaterial& material = instance.material(hit.triangle);
    return material.transmits() ? !material.constants.thin
                                : instance.prototype->mesh.closed && clear_material(instance);
  }

 private:
  const SceneSnapshot& scene_;
};

// True if the boundary of `own` is one of media: `inside`, where a ray leaves `own`, which is one of `media`, or enters
// it.
bool is_boundary(const Interior& own, bool inside, const MediumStack& media) {
  // Within another shell of its mesh it is no wall of the body.
  if (media.count(own.instance) > (inside ? 1u : 0u)) return false;
  const Interior* const current = media.current();
  return inside ? current->instance == own.instance : !current || current->priority <= own.priority;
}

bool is_same(const Interior* a, const Interior* b) {
  return a && b ? a->instance == b->instance : a == b;
}

}  // namespace

// The winding of a closed mesh that does not wind outward, such as one
// whose faces are all doubled, does not tell; `media` do, in which the ray arrives.
bool is_seen_from_inside(const Vertex& v, const MediumStack& media) {
  const Mesh& mesh = v.instance->prototype->mesh;
  if (!mesh.outward && mesh.closed) [[unlikely]]
    return media.contains(v.triangle.instance);
  return is_behind(*v.instance, v.triangle, -v.hit.ng);
}

Interior interior_of(const Vertex& v) {
  const DisneyParameters& p = v.material;
  Interior interior{v.triangle.instance, interior_priority(*v.instance, v.placement(), p.priority, v.triangle.instance),
                    p.ior};
  interior.index_matched = is_index_matched(v);
  const bool has_medium = v.has_medium();
  interior.scatters = has_medium && p.metallic < 1;
  const SubsurfaceBody* const body = v.instance->body;
  if (interior.scatters && body && body->occupied) [[unlikely]]
    interior.occupied = !(body->members[v.instance->member].shells->flags(v.triangle.triangle) &
                          (MeshShells::kOpen | MeshShells::kInner));
  // KHR_materials_dispersion: blue's index less red's is (ior - 1) dispersion / 20.
  interior.spread = 0.025f * p.dispersion * (p.ior - 1);
  // Where light scatters inside, walks absorb it.
  if (has_medium || !(p.attenuation_distance > 0)) return interior;
  constexpr float kBlackest = 1e-30f;
  for (int c = 0; c < 3; ++c)
    interior.sigma_a[c] = -std::log(std::max(p.attenuation_color[c], kBlackest)) / p.attenuation_distance;
  return interior;
}

void cross_interface(const Vertex& v, bool inside, MediumStack* media) {
  if (v.material.thin) return;
  if (inside)
    media->leave(v.triangle.instance);
  else
    media->enter(interior_of(v));
}

MediumStack media_past(const Vertex& v, MediumStack media) {
  if (v.beyond) return *v.beyond;
  cross_interface(v, v.side.inside, &media);
  return media;
}

Rgb passing_factor(const Vertex& v, const MediumStack& from, const MediumStack& to) {
  return is_index_matched(v) ? index_factor(from.indices(), to.indices()) : Rgb(1.0f);
}

Meeting resolve_interface(const PathContext& context, const PixelSampler& sampler, Vertex* v, Path* path) {
  const DisneyParameters& p = v->material;
  MediumStack& media = path->media;
  const uint32_t instance = v->triangle.instance;
  v->origins[Vertex::kFarSide] = {far_side_of(v->hit), {-v->hit.ng, -v->frame.n}};
  if (p.thin) {
    v->side = {p.ior / media.index(), false};
    return Meeting::visible;
  }
  const bool inside = is_seen_from_inside(*v, media);
  const Interior own = interior_of(*v);
  // A surface that is left without having been entered belongs to an open mesh.
  if (inside && !media.contains(instance)) media.enter(own);
  if (find_coincident_surfaces(context, sampler, inside, v, path)) return Meeting::replaced;

  // Find the media on this body's side and on the other one.
  const Interior* within = &own;
  const Interior* other = inside ? media.current_without(instance) : media.current();
  bool is_visible = is_boundary(own, inside, media);
  if (v->beyond) [[unlikely]] {
    within = inside ? media.current() : v->beyond->current();
    other = inside ? v->beyond->current() : media.current();
    is_visible = !is_same(within, other);
  }
  if (!is_visible) {
    if (v->beyond)
      media = *v->beyond;
    else
      cross_interface(*v, inside, &media);
    if (v->air_beyond) path->air = *v->air_beyond;
    path->pass(*v);
    return Meeting::hidden;
  }

  // Choose a channel where they disperse, and find the relative index.
  const auto index = [](const Interior* at, int channel) { return at ? at->index(channel) : 1; };
  const bool disperses = (within && within->spread > 0) || (other && other->spread > 0);
  if (disperses && p.spec_trans > 0 && has_several_channels(path->throughput))
    choose_channel(v->u.bsdf.data(), &path->throughput);
  const int channel = channel_of(path->throughput);
  const float eta = index(within, channel) / index(other, channel);
  v->side = {inside ? 1 / eta : eta, inside, !v->instance->prototype->mesh.closed};
  return Meeting::visible;
}

bool is_hidden_boundary(const PathContext& context, const Ray& ray, const TriangleHit& hit, const MediumStack& media) {
  const DisneyMaterial& material = context.scene.instance(hit.instance).material(hit.triangle);
  if (media.empty() || !material.transmits() || material.constants.thin) return false;
  Vertex v;
  evaluate_surface(context, ray, hit, 0, &v);
  const bool inside = is_seen_from_inside(v, media);
  const Interior own = interior_of(v);
  MediumStack about = media;
  if (inside && !about.contains(hit.instance)) about.enter(own);
  return v.material.transmits() && !is_boundary(own, inside, about);
}

MediumStack interiors_at(const PathContext& context, Ray ray, Seeker seeker) {
  const ClearSurfaces filter(context.scene);
  const bool is_camera = seeker == Seeker::camera;
  MediumStack entered, about;
  SmallStack<Interior> found;
  TriangleHit hit;
  Vertex v;
  ray.tmax = std::numeric_limits<float>::infinity();
  for (int i = 0; i < kMaxCrossings; ++i) {
    ++(is_camera ? context.counters.camera_rays : context.counters.bounce_rays);
    if (!context.scene.top->intersect(ray, &hit, &filter)) break;
    evaluate_surface(context, ray, hit, 0, &v);
    ray.org = far_side_of(v.hit);
    const bool inside = is_seen_from_inside(v, entered);
    // Behind an opaque face is what is behind the clear ones.
    const DisneyMaterial* behind = nullptr;
    if (!v.material.transmits() && v.instance->prototype->mesh.closed) [[unlikely]]
      behind = clear_material(*v.instance);
    if (behind) [[unlikely]]
      behind->evaluate(v.instance->primvars_at(hit, v.hit.uv), &v.material);
    if (!v.material.transmits() || (is_camera && v.instance->options.camera_cull == CameraCull::all)) continue;
    // The way out of this body is not seen: the camera's ray would carry its interior on.
    if (is_camera && inside && is_culled(*v.instance, hit, ray.dir)) continue;
    Interior interior = interior_of(v);
    if (behind) [[unlikely]]
      interior.index_matched = !(behind->constants.spec_trans > 0);
    if (!inside)
      entered.enter(interior);
    else if (entered.contains(hit.instance))
      entered.leave(hit.instance);
    else
      found.push(interior);
  }
  // The surface that is left last was entered first.
  for (uint32_t i = found.size(); i > 0; --i) about.enter(found[i - 1]);
  return about;
}

}  // namespace alabaster
