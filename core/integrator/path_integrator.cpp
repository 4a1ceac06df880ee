#include "core/integrator/path_integrator.h"

#include "core/diagnostics/check.h"
#include "core/integrator/boundary.h"
#include "core/integrator/camera_interiors.h"
#include "core/integrator/first_hit.h"
#include "core/integrator/path_surface.h"
#include "core/integrator/surface_light.h"

namespace alabaster {

namespace {

bool intersect(const PathContext& context, const PixelSampler& sampler, PathState* path, TriangleHit* hit) {
  if (trace(context, sampler, path, hit)) return true;
  if (!is_traceable(path->ray)) ++context.counters.rejected_rays;
  return false;
}

// The weight of light that the path's ray meets, against sampling of that light.
float weight_of_met(const PathState& path, float light_pdf) {
  return path.scatter_pdf > 0 ? power_heuristic(path.scatter_pdf, light_pdf) : 1.0f;
}

// Emission of the lights without geometry that the path's segment meets.
Rgb analytic_light_emission(const PathState& path, bool escaped) {
  const auto weigh = [&path](float light_pdf) { return weight_of_met(path, light_pdf); };
  const LightSet& lights = *path.lights;
  if (path.interiors.empty()) return lights.emitted(path.ray, escaped, path.depth == 0, path.search, weigh);
  return lights.emitted(path.ray, escaped, path.depth == 0, path.search, [&](float light_pdf, float distance) {
    return path.interiors.transmittance(distance) * weigh(light_pdf);
  });
}

// Emission of the lights with a shadow link that the path's ray meets beyond what casts no shadow for them. `escaped`:
// the ray met no surface.
Rgb linked_light_emission(const PathContext& context, const PathState& path, bool escaped) {
  const auto weigh = [&path](float light_pdf) { return weight_of_met(path, light_pdf); };
  const bool is_clear = escaped && !context.sees_through();
  return path.lights->emitted_with_links(path.ray, path.search, weigh, [&](uint32_t link, float distance) -> Rgb {
    const Ray ray{path.ray.org, path.ray.dir, distance, path.ray.time};
    if (is_clear) return path.through_interiors(Rgb(1.0f), distance);
    ++context.counters.shadow_rays;
    return path.through_interiors(Rgb(linked_visibility(context.scene, ray, link, &path.interiors)), distance);
  });
}

void add_mesh_emission(const PathVertex& v, PathState* path) {
  if (is_black(v.material.emission)) return;
  const TriangleHit& hit = v.triangle;
  float weight = 1;
  if (path->scatter_pdf > 0)
    weight = weight_of_met(*path, path->lights->mesh_light_pdf(path->ray, hit.t, hit.instance, hit.triangle));
  path->radiance += path->throughput * v.material.emission * weight;
}

// Ends a camera's path at a hold-out: only lights that it met on its way show.
void hold_out(PathRecord* record, PathState* path, FilmSample* out) {
  path->held_out = true;
  out->alpha = 0;
  if (record) record->end("a hold-out");
}

// Roulette ends paths whose throughput has fallen below this, and lifts survivors to it. A survivor that is lifted far
// is a firefly where a later lobe meets a light (testenv/benchmark/results/sampling.md).
constexpr float kRouletteBelow = 0.125f;

// Unbiased: survivors carry the weight of the ended. `draw` gives the random number, where one is needed.
template <class Draw>
bool survives_roulette(const Draw& draw, PathState* path) {
  if (path->depth == 0) return true;
  float throughput = max_component(path->throughput);
  // Radiance in a medium is larger by its index squared, and the throughput of a path that enters it smaller.
  if (!path->interiors.empty()) throughput *= sqr(path->interiors.index());
  if (!(throughput < kRouletteBelow)) return true;
  const float survival = throughput * (1 / kRouletteBelow);
  if (!(draw() < survival)) return false;
  path->throughput *= 1 / survival;
  return true;
}

// False: the direction leads into the surface.
bool scatter_at_surface(const PathContext& context, const PathVertex& v, const BsdfSample& sample, PathState* path) {
  const Vec3f wi = v.frame.to_world(sample.wi);
  if (!v.is_above_surface(wi)) return false;
  path->throughput *= sample.f * (std::abs(sample.wi.z) / sample.pdf);
  path->scatter_pdf = sample.pdf;
  path->go_on(origin_of(context, v.departure, wi), wi);
  return true;
}

template <bool kLayers, class Draw>
bool survives(const PathContext& context, const Draw& draw, PathState* path) {
  if (!is_black(path->throughput) && survives_roulette(draw, path)) return true;
  if (PathRecord* record = record_of<kLayers>(context)) record->end("throughput is black, or roulette ended it");
  return false;
}

template <SubsurfaceMode kMode, bool kMeshLights, bool kLayers>
void follow_path(const PathContext& context, const PixelSampler& sampler, PathState* path, FilmSample* first_hit,
                 LayerSplit* split);

// Splits the path at the first surface into paths, each with its share of the light. `send(sampler, path)` sends one
// on, and is false if it ends; `sort(light, walk)` puts what it brought into layers, with the walk that it began with.
template <SubsurfaceMode kMode, bool kMeshLights, bool kLayers, class Send, class Sort>
void split_path(const PathContext& context, const PixelSampler& sampler, PathState* path, const Send& send,
                const Sort& sort) {
  for (uint32_t i = 0; i < kPathsPerSample; ++i) {
    const PixelSampler branch_sampler = sampler.of_branch(i, kPathsPerSample);
    if (PathRecord* record = record_of<kLayers>(context)) record->branch(i, kPathsPerSample);
    PathState branch = *path;
    branch.radiance = Rgb(0.0f);
    if (i > 0) branch.guides = nullptr;  // one path finds them
    const bool continues = send(branch_sampler, &branch);
    const float share = 1 / static_cast<float>(kPathsPerSample);
    const WalkLayers walk{branch.walk_events, branch.twin_light * share};
    if (continues) follow_path<kMode, kMeshLights, kLayers>(context, branch_sampler, &branch, nullptr, nullptr);
    const Rgb light = branch.radiance * share;
    path->radiance += light;
    if (kLayers) sort(light, walk);
  }
}

// Continues below the surface.
template <SubsurfaceMode kMode, bool kLayers>
bool continue_below(const PathContext& context, const PixelSampler& sampler, const VertexBelow& below,
                    PathState* path) {
  path->guides = nullptr;
  const bool continues = scatter_below_surface<kMode>(context, sampler, below, path);
  const auto draw = [&, depth = path->depth] { return sampler.draw(Dimension::bsdf, depth)[3]; };
  ++path->depth;
  return continues && survives<kLayers>(context, draw, path);
}

// Continues below the surface, once the path's throughput has the weight of the entry. `within`: the path came to the
// vertex through the medium.
template <SubsurfaceMode kMode, bool kMeshLights, bool kLayers>
bool enter_below(const PathContext& context, const PixelSampler& sampler, const PathVertex& v, bool within,
                 PathState* path, LayerSplit* split) {
  const VertexBelow below(v, context.settings, within);
  if (path->depth > 0) return continue_below<kMode, kLayers>(context, sampler, below, path);
  split_path<kMode, kMeshLights, kLayers>(
      context, sampler, path,
      [&](const PixelSampler& branch_sampler, PathState* branch) {
        if (!continue_below<kMode, kLayers>(context, branch_sampler, below, branch)) return false;
        if (keeps_footprints(context)) branch->footprint.scatter(branch->scatter_pdf);
        return true;
      },
      [&](const Rgb& light, const WalkLayers& walk) { split->add_below(light, walk); });
  return false;
}

// The lobe that sent a path on, and the layer of what it brings.
struct LobeChoice {
  Lobe lobe = Lobe::straight;
  Rgb specular_share{0.0f};  // of f; only where layers are split
};

// Samples a lobe, and sends the path on by it. False: the path ends.
template <SubsurfaceMode kMode, bool kLayers>
bool continue_by_lobe(const PathContext& context, const PixelSampler& sampler, const std::array<float, 4>& u,
                      LobedVertex* at, PathState* path, LobeChoice* choice) {
  PathRecord* const record = record_of<kLayers>(context);
  const bool splits = kLayers && path->depth == 0;
  Rgb specular;
  const auto sample = at->bsdf.sample(u[0], {u[1], u[2]}, splits ? &specular : nullptr);
  if (sample) DCHECK_GE(sample->pdf, 0.0f);
  if (record && sample) record->sample_lobe(lobe_name(sample->lobe), sample->f, sample->pdf);
  if (record && !sample) record->end("no direction was sampled");
  if (!sample) return false;
  choice->lobe = sample->lobe;
  if (!is_mirror(at->v, sample->lobe)) path->guides = nullptr;
  if (kMode != SubsurfaceMode::lambert && sample->lobe == Lobe::subsurface) {
    path->throughput *= sample->f * (1 / sample->pdf);
    if (!at->below) at->below.emplace(at->v, context.settings, false).flat = at->flat;
    return continue_below<kMode, kLayers>(context, sampler, *at->below, path);
  }
  const bool leaves = scatter_at_surface(context, at->v, *sample, path);
  if (record && !leaves) record->end("the direction leads into the surface");
  if (!leaves) return false;
  if (splits) choice->specular_share = share_of(specular, sample->f);
  ++path->depth;
  return survives<kLayers>(
      context, [&] { return u[3]; }, path);
}

// Splits the path at the first surface into paths that its lobes send on.
template <SubsurfaceMode kMode, bool kMeshLights, bool kLayers>
void split_by_lobes(const PathContext& context, const PixelSampler& sampler, LobedVertex* at, PathState* path,
                    LayerSplit* split) {
  LobeChoice choice;
  split_path<kMode, kMeshLights, kLayers>(
      context, sampler, path,
      [&](const PixelSampler& branch_sampler, PathState* branch) {
        choice = {};
        const auto u = branch_sampler.draw(Dimension::bsdf, 0);
        if (!continue_by_lobe<kMode, kLayers>(context, branch_sampler, u, at, branch, &choice)) return false;
        if (keeps_footprints(context)) branch->footprint.scatter(branch->scatter_pdf);
        // The directions of all paths compete with each sampled light. The footprint is that of one.
        if (choice.lobe != Lobe::subsurface) branch->scatter_pdf *= kPathsPerSample;
        return true;
      },
      [&](const Rgb& light, const WalkLayers& walk) {
        if (choice.lobe == Lobe::subsurface)
          split->add_below(light, walk);
        else
          split->add_local(light, choice.specular_share);
      });
}

// Samples direct light and the next direction at the vertex. False: the path ends.
template <SubsurfaceMode kMode, bool kMeshLights, bool kLayers>
bool scatter(const PathContext& context, const PixelSampler& sampler, const PathVertex& v, const VertexNumbers& numbers,
             PathState* path, LayerSplit* split) {
  // Evaluate the BSDF's parameters for the viewer's direction.
  const bool splits = kLayers && path->depth == 0;
  if (splits) split->emission = path->radiance, split->scattered = true;
  const DisneyBsdf bsdf(v.material, v.frame.to_local(-path->ray.dir), context.settings.energy);
  LobedVertex at{v, bsdf};

  // Sample the lights.
  add_direct_light<kMode, kLayers>(context, numbers.light, &at, path, split);

  // Sample lobes and directions.
  if (path->depth == 0) {
    split_by_lobes<kMode, kMeshLights, kLayers>(context, sampler, &at, path, split);
    return false;
  }
  LobeChoice choice;
  return continue_by_lobe<kMode, kLayers>(context, sampler, numbers.bsdf, &at, path, &choice);
}

template <SubsurfaceMode kMode, bool kMeshLights, bool kLayers>
bool continue_path(const PathContext& context, const PixelSampler& sampler, const PathVertex& v,
                   const VertexNumbers& numbers, PathState* path, LayerSplit* split) {
  if (continues_within_medium<kMode>(context, v, *path)) {
    // The surface has no lobes on that side.
    if (kLayers && path->depth == 0) split->emission = path->radiance, split->scattered = true;
    return enter_below<kMode, kMeshLights, kLayers>(context, sampler, v, true, path, split);
  }
  if (v.material.transmits()) [[unlikely]] {
    const std::optional<Lobe> lobe = scatter_at_boundary(context, v, numbers, path, split);
    if (!lobe) return false;
    if (!is_mirror(v, *lobe)) path->guides = nullptr;
    if (kMode != SubsurfaceMode::lambert && *lobe == Lobe::subsurface)
      return enter_below<kMode, kMeshLights, kLayers>(context, sampler, v, false, path, split);
    ++path->depth;
    return survives<kLayers>(
        context, [&] { return numbers.bsdf[3]; }, path);
  }
  return scatter<kMode, kMeshLights, kLayers>(context, sampler, v, numbers, path, split);
}

// Draws the vertex's random numbers while its triangle comes from memory.
inline VertexNumbers draw_numbers(const PixelSampler& sampler, uint32_t depth, const Mesh& mesh, uint32_t triangle) {
  VertexNumbers numbers;
  numbers.light = sampler.draw(Dimension::light, depth);
  prefetch_corners(mesh, triangle, Attributes::normals_and_uvs);
  numbers.bsdf = sampler.draw(Dimension::bsdf, depth);
  return numbers;
}

// Meets the surface of a material that transmits. True: the surface is not there, and the path's ray goes on behind it.
// *v becomes the vertex on the surface that counts where several coincide.
template <SubsurfaceMode kMode, bool kLayers>
bool goes_behind(const PathContext& context, const PixelSampler& sampler, float* u, PathVertex* v, PathState* path) {
  PathRecord* const record = record_of<kLayers>(context);
  Meeting meeting = meet_boundary(context, sampler, v, path, u);
  while (meeting == Meeting::other) {
    *v = vertex_on<kMode>(context, v->triangle, *path);
    if (record) record->meet_surface(*v->instance, v->triangle, v->hit);
    meeting = v->material.transmits() ? meet_boundary(context, sampler, v, path, u) : Meeting::boundary;
  }
  if (meeting == Meeting::nothing && record) record->sample_lobe(lobe_name(Lobe::straight), Rgb(1.0f), 1);
  return meeting == Meeting::nothing;
}

template <SubsurfaceMode kMode, bool kMeshLights, bool kLayers>
void follow_path(const PathContext& context, const PixelSampler& sampler, PathState* path, FilmSample* first_hit,
                 LayerSplit* split) {
  PathRecord* const record = record_of<kLayers>(context);
  bool is_vertex = path->depth > 0;  // where the ray begins
  float passed = 0;                  // length of the segments up to boundaries that the path went straight through
  while (true) {
    // Trace the path's ray to the nearest surface.
    if (record) record->follow(path->ray, path->throughput, path->scatter_pdf);
    ++(path->depth == 0 ? context.counters.camera_rays : context.counters.bounce_rays);
    TriangleHit hit;
    const float reach = path->ray.tmax;  // of a camera's ray, its far plane
    const bool found = intersect(context, sampler, path, &hit);
    if (kMode == SubsurfaceMode::walk && found && !path->interiors.empty()) [[unlikely]]
      find_own_wall(context, *path, &hit);
    const Mesh* const mesh = found ? &context.scene.instance(hit.instance).prototype->mesh : nullptr;
    if (found) path->ray.tmax = hit.t, prefetch_triangle(*mesh, hit.triangle);

    // Add emission of lights without geometry; of infinite lights only if the ray escaped.
    Rgb met = path->throughput * analytic_light_emission(*path, !found);
    if (path->lights->has_shadow_links() && is_vertex) [[unlikely]]
      met += path->throughput * linked_light_emission(context, *path, !found);
    path->radiance += met;
    if (record) record->meet_light(met);
    if (record && !found) record->end("the ray meets no surface");
    if (!found) return;
    if (!path->interiors.empty()) path->throughput *= path->interiors.transmittance(hit.t);

    VertexNumbers numbers = draw_numbers(sampler, path->depth, *mesh, hit.triangle);

    // Find the surface and the material at the vertex.
    PathVertex vertex = find_vertex<kMode>(context, hit, path);
    if (record) record->meet_surface(*vertex.instance, hit, vertex.hit);
    if (vertex.material.transmits() &&
        goes_behind<kMode, kLayers>(context, sampler, numbers.bsdf.data(), &vertex, path)) [[unlikely]] {
      path->ray.tmax = reach - hit.t;
      passed += hit.t;
      is_vertex = false;
      continue;
    }

    // Record the first hit and add the surface's emission; end at a hold-out or the depth limit.
    if (path->depth == 0) record_first_hit(context, vertex, passed + hit.t, first_hit);
    if (path->guides) record_guides(context, vertex, *path);
    if (path->depth == 0 && vertex.instance->options.holdout && first_hit) [[unlikely]]  // a camera's path has one
      return hold_out(record, path, first_hit);
    const Rgb before = path->radiance;
    if (kMeshLights) add_mesh_emission(vertex, path);
    if (kMeshLights && record) record->meet_light(path->radiance - before);
    if (record && path->depth >= context.settings.max_depth) record->end("maxDepth");
    if (path->depth >= context.settings.max_depth) return;

    // Sample direct light and the next ray, at the surface or below it.
    if (!continue_path<kMode, kMeshLights, kLayers>(context, sampler, vertex, numbers, path, split)) return;
    if (keeps_footprints(context)) path->footprint.scatter(path->scatter_pdf);
    is_vertex = true;
  }
}

template <SubsurfaceMode kMode, bool kMeshLights, bool kLayers>
FilmSample trace_path(const PathContext& context, const Ray& camera_ray, const PixelSampler& sampler) {
  FilmSample out;
  out.distance = std::numeric_limits<float>::infinity();
  PathState path;
  path.ray = camera_ray;
  path.lights = &context.scene.lights;
  if (context.aovs & kGuideAovs) path.guides = &out;
  if (context.camera_interiors) [[unlikely]]
    path.interiors = context.camera_interiors->of(context, camera_ray);
  if (keeps_footprints(context)) path.footprint.cone = context.camera.pixel_cone(camera_ray.dir);
  LayerSplit split;
  follow_path<kMode, kMeshLights, kLayers>(context, sampler, &path, &out, kLayers ? &split : nullptr);

  // Sort the light into layers; a backdrop that the camera sees is part of the picture.
  out.color = path.radiance;
  if (kLayers) *context.layers = split.finish(path.radiance);
  const bool has_backdrop = context.scene.features.visible_background && !path.held_out;
  if (out.alpha == 0 && (has_backdrop || !is_black(path.radiance))) out.alpha = 1;
  return out;
}

template <SubsurfaceMode kMode, bool kLayers>
PathIntegrator select_for_lights(const SceneFeatures& features) {
  return features.emissive_meshes ? trace_path<kMode, true, kLayers> : trace_path<kMode, false, kLayers>;
}

template <bool kLayers>
PathIntegrator select_variant(const SceneFeatures& features, const IntegratorSettings& settings) {
  switch (features.subsurface ? settings.subsurface : SubsurfaceMode::lambert) {
    case SubsurfaceMode::walk:
    case SubsurfaceMode::reference:  // differs in its settings
      return select_for_lights<SubsurfaceMode::walk, kLayers>(features);
    case SubsurfaceMode::diffusion:
      return select_for_lights<SubsurfaceMode::diffusion, kLayers>(features);
    case SubsurfaceMode::lambert:
      break;
  }
  return select_for_lights<SubsurfaceMode::lambert, kLayers>(features);
}

}  // namespace

PathIntegrator select_path_integrator(const SceneFeatures& features, const IntegratorSettings& settings, bool layers) {
  return layers ? select_variant<true>(features, settings) : select_variant<false>(features, settings);
}

}  // namespace alabaster
