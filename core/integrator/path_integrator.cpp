#include "core/integrator/path_integrator.h"

#include "core/integrator/camera_interiors.h"
#include "core/integrator/direct_light.h"
#include "core/integrator/emission.h"
#include "core/integrator/first_hit.h"
#include "core/integrator/interface.h"
#include "core/integrator/path_record.h"
#include "core/integrator/see_through.h"
#include "core/integrator/subsurface_scatter.h"
#include "core/integrator/vertex_bsdf.h"
#include "core/subsurface/medium.h"

namespace alabaster {
namespace {

bool end(const PathContext& context, const char* reason) {
  if (context.record) context.record->end(reason);
  return false;
}

// The path has no bounce left.
bool end_at_depth(const PathContext& context, const Path& path) {
  if (path.uncounted < Path::kMostUncounted) return end(context, "maxDepth");
  ++context.counters.walk_safety_cap;
  return end(context, "the light met too many surfaces within bodies");
}

// Finds the nearest surface that stops the path's ray. Updates path->air by the holes on the way.
bool intersect(const PathContext& context, const PixelSampler& sampler, Path* path, TriangleHit* hit) {
  const auto& top = *context.scene.top;
  bool found = top.intersect(path->ray, hit);
  if (found && context.sees_through()) {
    // Most rays stop at the first surface. Only the others ask at all that they meet.
    const StochasticStop filter(context.scene, path->ray.dir, path->media, sampler, path->depth);
    if (!filter.stops(*hit)) {
      found = top.intersect(path->ray, hit, &filter);
      filter.cross_holes(found ? hit->t : std::numeric_limits<float>::infinity(), &path->air);
    }
  }
  if (!found && !is_traceable(path->ray)) ++context.counters.rejected_rays;
  if (found && context.mode() == SubsurfaceMode::walk && !path->media.empty()) [[unlikely]]
    find_own_wall(context, *path, hit);
  return found;
}

// Draws the vertex's random numbers while its triangle comes from memory.
void draw_numbers(const PixelSampler& sampler, uint32_t depth, const Mesh& mesh, uint32_t triangle, VertexSamples* u) {
  u->light = sampler.draw(Dimension::light, depth);
  prefetch_corners(mesh, triangle, Attributes::normals_and_uvs);
  u->bsdf = sampler.draw(Dimension::bsdf, depth);
  u->roulette = u->bsdf[3];
}

// Follows the path's segment to the vertex at its end. Adds the emission on the way and there. False: the path ends.
// `first_hit` takes the values of the camera's first hit.
bool find_next_vertex(const PathContext& context, const PixelSampler& sampler, Path* path, FilmSample* first_hit,
                      Vertex* v) {
  PathRecord* const record = context.record;

  // Follow a walk to its exit, or to what stands in the body. The ray from an exit that is not there counts as a
  // bounce.
  bool met_within = false;
  if (path->walk.entry) {
    const Exit exit = find_exit(context, sampler, path, v);
    if (exit == Exit::vertex || exit == Exit::none) return exit == Exit::vertex;
    met_within = exit == Exit::within;
    if (met_within) find_members(context, v->triangle, path);
    if (exit == Exit::passes) {
      ++path->depth;
      path->from_vertex = true;
      path->specular_share = Rgb(1.0f);
      path->hidden_boundary = nullptr;  // no ray has met light on the way
      if (!survives_roulette(context, path->walk.roulette, path)) return false;
    }
  }

  float passed = 0;  // length of the segments up to hidden interfaces
  while (true) {
    TriangleHit& hit = v->triangle;
    const float reach = path->ray.tmax;  // of a camera's ray, its far plane
    if (!met_within && is_cloudy(context, path->media)) [[unlikely]] {
      // The segment is a walk. The wall straight ahead says which medium it goes through.
      if (!find_wall_ahead(context, *path, &hit)) return end(context, "the medium has no wall ahead");
      draw_numbers(sampler, path->depth, context.scene.instance(hit.instance).prototype->mesh, hit.triangle, &v->u);
      make_vertex_within(context, *path, v);
      passed += hit.t;
      break;
    }
    if (!met_within) {
      // Intersect the scene. Lights without geometry emit along the ray.
      if (record) record->follow(path->ray, path->throughput, path->pdf);
      ++(path->depth == 0 ? context.counters.camera_rays : context.counters.bounce_rays);
      const bool found = intersect(context, sampler, path, &hit);
      if (found) {
        path->ray.tmax = hit.t;
        prefetch_triangle(context.scene.instance(hit.instance).prototype->mesh, hit.triangle);
      }
      const Rgb met = meet_lights(context, !found, path);
      if (record) record->meet_light(met);
      if (!found) return end(context, "the ray meets no surface");
      path->travel(context, hit.t);
      if (context.mode() == SubsurfaceMode::walk && is_wall_of_union(context, *path, hit)) [[unlikely]] {
        draw_numbers(sampler, path->depth, context.scene.instance(hit.instance).prototype->mesh, hit.triangle, &v->u);
        make_vertex_within(context, *path, v);
        passed += hit.t;
        break;
      }
    }

    // Find the surface and its material. Pass a dielectric interface that a medium of higher priority hides.
    draw_numbers(sampler, path->depth, context.scene.instance(hit.instance).prototype->mesh, hit.triangle, &v->u);
    Meeting meeting = Meeting::replaced;
    while (meeting == Meeting::replaced) {
      make_vertex(context, hit, *path, v);
      if (record) record->meet_surface(*v->instance, hit, v->hit);
      meeting = v->material.transmits() ? resolve_interface(context, sampler, v, path) : Meeting::visible;
    }
    if (meeting == Meeting::visible) {
      passed += hit.t;
      break;
    }
    if (record) record->sample_lobe(lobe_name(Lobe::straight), Rgb(1.0f), 1);
    path->ray.tmax = reach - hit.t;
    path->forget_ended_stays(context.scene);
    passed += hit.t;
    met_within = false;
  }
  // A diffusion profile has no way through the medium, only ways into it.
  if (!met_within && context.mode() == SubsurfaceMode::walk && is_within_medium(context, *v, *path)) set_within(v);

  // Record the first hit and the denoiser's features; end at a hold-out or a shadow catcher.
  if (path->depth == 0) record_first_hit(context, *v, *path, sampler, passed, first_hit);
  if (path->features) record_features(context, *v, *path);
  const MeshOptions& options = v->instance->options;
  if (path->depth == 0 && (options.holdout || options.shadow_catcher) && first_hit) [[unlikely]] {
    path->held_out = first_hit->is_held_out = true;  // only lights on the way show
    first_hit->alpha = first_hit->ambient_occlusion = 0;
    if (options.holdout) return end(context, "a hold-out");
    if (is_black(path->radiance) && context.aovs & aov_bit(Aov::shadow))
      catch_shadows(context, *v, path->media, first_hit);
    return end(context, "a shadow catcher");
  }

  // Add the surface's emission.
  if (!is_black(v->material.emission)) {
    const Rgb emission = surface_emission(*v, *path);
    path->add(emission);
    path->add_to_group(v->instance->light_group, emission);
    if (record) record->meet_light(emission);
  }
  if (!path->may_bounce(context) && !path->may_pass_sheet(*v)) return end_at_depth(context, *path);
  return true;
}

// Sets the path's next segment: a ray, or a walk below the surface. False: the path ends.
bool scatter(const PathContext& context, Vertex* v, const VertexBsdf& bsdf, const VertexSamples& u, Path* path) {
  ScatterSample sample;
  if (!bsdf.sample(u.bsdf, &sample)) return end(context, "no direction was sampled");
  if (!path->may_bounce(context) && sample.lobe != Lobe::straight) return end_at_depth(context, *path);
  path->throughput *= sample.weight;
  if (sample.lobe == Lobe::subsurface) {
    path->enter(context, v, u.roulette);  // no bounce yet: the exit is the next vertex
    return true;
  }
  path->leave(context, *v, bsdf, sample);
  return survives_roulette(context, u.roulette, path);
}

// Calls itself for the branches of the first vertex, and no deeper. `vertices`: room for the path's vertex and for that
// of a branch.
void follow_path(const PathContext& context, const PixelSampler& sampler, Path* path, FilmSample* first_hit,
                 Vertex* vertices) {
  Vertex& v = vertices[0];
  while (find_next_vertex(context, sampler, path, first_hit, &v)) {
    // Next-event estimation. The branches of the first vertex share its light samples.
    const VertexBsdf bsdf(context, v, *path);
    path->branches = path->depth == 0 ? bsdf.branches() : 1;
    if (bsdf.has_twins())
      v.control.emplace(obtained_albedo(v.material.medium_albedo(), context.settings.inversion), v.u.light);
    if (path->may_bounce(context)) sample_lights(context, bsdf, &v, path);

    // BSDF sampling.
    if (path->branches == 1) {
      if (!scatter(context, &v, bsdf, v.u, path)) return;
      continue;
    }
    const uint32_t branches = path->branches;
    LightLayers layers;
    for (uint32_t i = 0; i < branches; ++i) {
      if (context.record) context.record->branch(i, branches);
      const PixelSampler own = sampler.of_branch(i, branches);
      VertexSamples u{{}, own.draw(Dimension::bsdf, path->depth)};
      u.roulette = u.bsdf[3];
      if (path->layers) layers = {};
      Path branch = path->branch(i, branches, path->layers ? &layers : nullptr);
      if (scatter(context, &v, bsdf, u, &branch)) follow_path(context, own, &branch, nullptr, vertices + 1);
      path->join(branch, branches);
    }
    return;
  }
}

}  // namespace

FilmSample trace_path(const PathContext& context, const Ray& camera_ray, const PixelSampler& sampler) {
  FilmSample out;
  out.distance = std::numeric_limits<float>::infinity();
  Path path;
  path.ray = camera_ray;
  path.lights = &context.scene.lights;
  if (context.layers) *context.layers = {};
  path.layers = context.layers;
  if (context.light_groups) context.light_groups->clear();
  path.light_groups = context.light_groups;
  if (context.aovs & kGuideAovs) path.features = &out;
  if (context.camera_interiors) [[unlikely]]
    path.media = context.camera_interiors->of(context, camera_ray);
  if (keeps_footprints(context)) path.footprint.cone = context.camera.pixel_cone(camera_ray.dir);
  std::array<Vertex, 2> vertices;
  follow_path(context, sampler, &path, &out, vertices.data());

  // A backdrop that the camera sees is part of the picture.
  out.color = path.radiance;
  const bool has_backdrop = context.scene.features.visible_background && !path.held_out;
  if (out.alpha == 0 && (has_backdrop || !is_black(path.radiance))) out.alpha = 1;
  return out;
}

}  // namespace alabaster
