#include "core/integrator/path.h"

#include "core/integrator/direct_light.h"
#include "core/integrator/first_hit.h"
#include "core/integrator/path_record.h"
#include "core/integrator/see_through.h"
#include "core/integrator/vertex.h"
#include "core/integrator/vertex_bsdf.h"

namespace alabaster {

namespace {

// The way along a ray from the surface at its vertex to its origin beside it. Grazing directions count as if they rose
// by a sixteenth.
float gap_before(const SurfacePoint& hit, const Vec3f& direction) {
  return hit.offset / std::max(std::abs(dot(direction, hit.ng)), 0x1p-4f);
}

// True if the vertex is on what stands in one of the media, or on an opaque face of its body.
bool stands_within(const SceneSnapshot& scene, const MediumStack& media, const Vertex& v) {
  for (uint32_t i = 0; i < media.size(); ++i)
    if (media[i].occupied &&
        (v.kind == Vertex::Kind::surface || scene.instance(media[i].instance).body != v.instance->body))
      return true;
  return false;
}

}  // namespace

void Path::travel(const PathContext& context, float distance) {
  if (!media.empty()) throughput *= media.transmittance(distance);
  if (keeps_footprints(context)) footprint.travel(distance);
}

Path Path::branch(uint32_t index, uint32_t count, LightLayers* its_layers) const {
  Path branch = *this;
  branch.radiance = Rgb(0.0f);
  if (index > 0) branch.features = nullptr;  // one branch finds them
  branch.layers = its_layers;
  branch.branch_share = 1 / static_cast<float>(count);
  return branch;
}

void Path::join(const Path& branch, uint32_t count) {
  const float share = 1 / static_cast<float>(count);
  radiance += branch.radiance * share;
  if (layers) layers->add(*branch.layers, share);
}

bool Path::may_pass_sheet(const Vertex& v) const {
  const DisneyParameters& constants = v.instance->material(v.triangle.triangle).constants;
  return depth > 0 && constants.thin && constants.spec_trans > 0;
}

void Path::meet_within(const Vec3f& direction) {
  ray.dir = direction;
  ray.tmax = std::numeric_limits<float>::infinity();  // behind a hidden wall it goes on
  pdf = 0;                                            // no light is sampled in there
  straight = 0;
  from_vertex = false;
  ++depth;  // for numbers of its own
  ++uncounted;
}

void Path::forget_ended_stays(const SceneSnapshot& scene) {
  if (lobe_entries.empty()) [[likely]]
    return;
  std::erase_if(lobe_entries, [&](const LobeEntry& entry) {
    for (uint32_t i = 0; i < media.size(); ++i)
      if (scene.instance(media[i].instance).body == entry.body) return false;
    return true;
  });
}

void Path::leave(const PathContext& context, const Vertex& v, const VertexBsdf& bsdf, const ScatterSample& sample) {
  const bool was_within =
      !media.empty() && context.mode() == SubsurfaceMode::walk && stands_within(context.scene, media, v);
  const bool decides = seeks_layer();
  if (layers) {
    const bool through_clear = walk_decides_layer() && v.kind == Vertex::Kind::interface && sample.side == Side::far;
    if (decides) layer = {Layer::Kind::local, sample.specular, sample.side == Side::far};
    layer.through_clear = through_clear;
  }
  if (features && !is_mirror(v, sample.lobe)) features = nullptr;
  Vec3f origin;
  if (sample.side == Side::far) {
    throughput *= bsdf.factor_beyond();
    media = bsdf.media_beyond();
    forget_ended_stays(context.scene);
    if (v.air_beyond) [[unlikely]]
      air = *v.air_beyond;
    if (!air.empty()) air.leave(air_pocket_of(context.scene, v.triangle.instance));
    origin = v.origins[Vertex::kFarSide].p;
  } else {
    const bool is_smooth = v.leaves_from_smooth(sample.wi) && reaches_smooth_surface(context, v);
    origin = v.origins[is_smooth ? Vertex::kSmooth : Vertex::kFacet].p;
  }
  const bool goes_cloudy = is_cloudy(context, media);
  const bool passes_sheet = sample.lobe == Lobe::straight && may_pass_sheet(v) && !goes_cloudy;
  if (!passes_sheet) ++layer.legs;
  if (passes_sheet) {
    if (straight == 0) light_origin = ray.org;
    straight += ray.tmax;
  } else {
    straight = 0;
    if (context.scene.features.lobe_scales) [[unlikely]]
      specular_share = sample.specular, layer.is_new = decides;
    lights = &context.scene.lights_of(*v.instance);
    light_context = bsdf.light_context();
    if (keeps_footprints(context)) footprint.scatter(sample.pdf);
    pdf = sample.pdf * static_cast<float>(branches);  // the directions of all branches compete with each sampled light
    if (goes_cloudy) pdf = 0;
  }
  from_vertex = !passes_sheet && !goes_cloudy;
  hidden_boundary = nullptr;
  gap = media.empty() ? 0 : gap_before(v.hit, sample.wi);
  ray = {origin, sample.wi, std::numeric_limits<float>::infinity(), ray.time};
  branches = 1;
  ++depth;
  if (passes_sheet || was_within) ++uncounted;
}

void Path::pass(const Vertex& boundary) {
  ray = {boundary.origins[Vertex::kFarSide].p, ray.dir, std::numeric_limits<float>::infinity(), ray.time};
  gap = gap_before(boundary.hit, ray.dir);
  pdf = std::numeric_limits<float>::infinity();
  straight = 0;
  from_vertex = depth > 0;  // the camera's ray sees lights as they are
  hidden_boundary = boundary.instance;
}

void Path::enter(const PathContext& context, Vertex* v, float roulette) {
  features = nullptr;
  layer.is_new = false;
  branches = 1;
  lights = &context.scene.lights_of(*v->instance);
  v->find_medium(context.settings);
  walk = {v, roulette};
}

namespace {

// Roulette ends paths whose throughput has fallen below this, and lifts survivors to it. A survivor that is lifted far
// is a firefly where a later lobe meets a light (testenv/benchmark/results/sampling.md).
constexpr float kRouletteBelow = 0.125f;

}  // namespace

bool survives_roulette(const PathContext& context, float u, Path* path) {
  // Radiance in a medium is larger by its index squared, and the throughput of a path that enters it smaller.
  float throughput = max_component(path->throughput);
  if (!path->media.empty()) throughput *= sqr(path->media.index());
  const float survival = throughput < kRouletteBelow ? throughput * (1 / kRouletteBelow) : 1;
  if (is_black(path->throughput) || (survival < 1 && !(u < survival))) {
    if (context.record) context.record->end("throughput is black, or roulette ended it");
    return false;
  }
  if (survival < 1) path->throughput *= 1 / survival;
  return true;
}

}  // namespace alabaster
