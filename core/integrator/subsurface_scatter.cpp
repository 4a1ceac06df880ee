#include "core/integrator/subsurface_scatter.h"

#include "core/diagnostics/check.h"
#include "core/integrator/interface.h"
#include "core/integrator/path_record.h"
#include "core/integrator/see_through.h"
#include "core/integrator/shading_normal.h"
#include "core/scene/clear_bodies.h"
#include "core/subsurface/body.h"
#include "core/subsurface/normalized_diffusion.h"
#include "core/subsurface/random_walk.h"

namespace alabaster {
namespace {

bool is_wall_of(const Interior& medium, const Instance& around, const TriangleHit& hit, const Instance& met) {
  return hit.instance == medium.instance || (around.body && around.body->is_union() && met.body == around.body);
}

/// The surfaces of the body that an interior belongs to.
class OwnWalls final : public HitFilter {
 public:
  OwnWalls(const SceneSnapshot& scene, const Interior& medium)
      : scene_(scene), medium_(medium), around_(scene.instance(medium.instance)) {}
  bool stops(const TriangleHit& hit) const noexcept override {
    return is_wall_of(medium_, around_, hit, scene_.instance(hit.instance));
  }

 private:
  const SceneSnapshot& scene_;
  const Interior& medium_;
  const Instance& around_;
};

/// The media on the outer side of an exit. The walk crosses no surface of the clear bodies that touch its own body,
/// so they are found by a ray. The inside of an open surface cannot be found so: its interior stays as at the entry.
MediumStack media_beyond(const PathContext& context, const SubsurfaceExit& exit, const SubsurfaceBody& body,
                         const Path& path) {
  MediumStack beyond;
  const auto enter_those = [&](const MediumStack& all, bool closed) {
    for (uint32_t i = 0; i < all.size(); ++i)
      if (context.scene.instance(all[i].instance).prototype->mesh.closed == closed) beyond.enter(all[i]);
  };
  enter_those(path.media, false);
  if (!body.touched.empty()) {
    const Instance& instance = context.scene.instance(exit.hit.instance);
    std::optional<Placement> moved;
    const Placement& placement = instance.at(exit.hit, &moved);
    const SurfacePoint hit =
        on_side(surface_point(instance.prototype->mesh, exit.hit, placement.object_to_world, placement.world_to_object),
                exit.direction);
    const Ray ray{offset_point(hit.p, hit.ng, hit.offset), hit.ng, std::numeric_limits<float>::infinity(),
                  exit.hit.time};
    if (body.touched.contains(ray.org)) enter_those(interiors_at(context, ray, Seeker::path), true);
  }
  for (uint32_t i = 0; i < path.air.size(); ++i) {
    const SubsurfaceBody* const pocket = context.scene.instance(path.air[i]).body;
    if (pocket && pocket->is_union())
      for (const auto& member : pocket->members) beyond.leave(member.instance);
    else
      beyond.leave(path.air[i]);
  }
  for (const auto& member : body.members) beyond.leave(member.instance_of(exit.hit));
  return beyond;
}

/// A parameter of the material at an exit.
float value_at(const PathContext& context, const SubsurfaceExit& exit, float DisneyParameters::*parameter) {
  const Instance& instance = context.scene.instance(exit.hit.instance);
  const DisneyMaterial& material = instance.material(exit.hit.triangle);
  if (!material.varies(parameter)) return material.constants.*parameter;
  std::optional<Placement> moved;
  const Placement& placement = instance.at(exit.hit, &moved);
  const SurfaceHit hit = surface_on_side(instance, placement, exit.hit, exit.direction);
  return material.evaluate({instance.prototype->mesh, exit.hit, hit.uv}).*parameter;
}

/// Sets path->media to those beyond *exit. Where the index falls from the entry to the exit, the share (low / high)^2
/// of the walks passes, and the others come out at the entry: *exit becomes it (random_walk.md, "Clear bodies that
/// touch"). For lobes at both ends. True: it has become the entry.
bool cross_to_media(const PathContext& context, const PixelSampler& sampler, const Vertex& entry, Path* path,
                    SubsurfaceExit* exit) {
  const MediumStack beyond = media_beyond(context, *exit, *entry.instance->body, *path);
  const float share = sqr(beyond.index() / path->media.index());
  const auto u = sampler.draw(Dimension::exit_bsdf, path->depth);  // the last one chooses a clear exit
  if (share < 1 && entry.kind != Vertex::Kind::within && u[2] >= share &&
      u[3] >= value_at(context, *exit, &DisneyParameters::spec_trans)) {
    exit->hit = entry.triangle;
    exit->direction = entry.hit.ng;
    return true;
  }
  path->media = beyond;
  return false;
}

/// The layers at the entry as light along `dir` passed them.
DisneyLayers::Entered layers_entered(const Vertex& entry, const Vec3f& dir) {
  const bool inside = entry.side.inside && !entry.side.open;
  const auto passed = inside ? std::nullopt : DisneyLayers::of(entry.material);
  return passed ? passed->entered(entry.frame.to_local(-dir)) : DisneyLayers::Entered();
}

/// The layers over the exit, of a material that has some. `at`: the vertex there. `entered`: those at the entry. A path
/// that began within passed none: those of the exit are as if its light came from everywhere.
std::optional<ExitLayers> layers_at(const Vertex& at, const SubsurfaceExit& exit, bool is_within,
                                    const DisneyLayers::Entered& entered) {
  const DisneyMaterial& material = at.instance->material(exit.hit.triangle);
  const SurfaceHit hit = surface_on_side(*at.instance, at.placement(), exit.hit, exit.direction);
  DisneyParameters p = material.evaluate({at.instance->prototype->mesh, exit.hit, hit.uv});
  const auto& map = material.coat_normal_map;
  if (map || material.normal_map)
    p.coat_normal = at.frame.to_local(map ? mapped_normal(*at.instance, at.placement(), exit.hit, hit, *map) : hit.ns);
  const auto layers = DisneyLayers::of(p);
  if (!layers) return std::nullopt;
  return ExitLayers{*layers, is_within ? layers->from_within() : entered};
}

}  // namespace

Exit find_exit(const PathContext& context, const PixelSampler& sampler, Path* path, Vertex* v) {
  PathRecord* const record = context.record;
  Vertex& entry = *path->walk.entry;  // it may be *v, which is written last
  const std::optional<ControlVariate>& control = entry.control;
  const bool is_within = entry.kind == Vertex::Kind::within;
  const SubsurfaceBody& body = *entry.instance->body;
  path->walk.entry = nullptr;

  // Walk. Where no walk is followed, the twin has its expectation.
  SubsurfaceEntry start{entry.triangle, entry.instance->member, entry.hit,
                        entry.frame.n,  path->throughput,       entry.medium};
  if (is_within) start.within = path->ray;
  const bool has_twin = control && !is_black(control->light);
  if (has_twin) DCHECK(entry.medium->medium.albedo == entry.material.base_color);
  Rgb twin = has_twin ? path->throughput * control->albedo : Rgb(0.0f);
  SubsurfaceNumbers numbers(sampler, Dimension::subsurface, path->depth);
  const RandomWalk walk{context.settings.walk, record ? record->walk() : nullptr, has_twin ? &twin : nullptr};
  auto exit = context.mode() == SubsurfaceMode::diffusion
                  ? NormalizedDiffusion{}.carry(body, start, numbers, context.counters)
                  : walk.carry(body, start, numbers, context.counters);
  if (has_twin) {
    const Rgb taken = twin * control->light * -1.0f;
    path->add_of_walks(taken);
    if (record) record->twin_leaves(taken);
  }
  if (!exit) {
    if (record) record->end("the light did not leave the body");
    return Exit::none;
  }
  if (path->seeks_layer()) path->layer = {Layer::Kind::below, Rgb(0.0f), exit->events};
  path->throughput = exit->throughput;

  // Find the media beyond the exit.
  const Rgb index = path->media.indices();
  const bool may_cross = !path->media.empty() || !body.touched.empty();
  const bool is_back = may_cross && cross_to_media(context, sampler, entry, path, &*exit);
  if (body.is_union() && !path->air.empty()) [[unlikely]]  // the walk left the union's medium
    path->air.leave(body.members.front().instance);
  const Instance& instance = context.scene.instance(exit->hit.instance);
  const DisneyMaterial& material = instance.material(exit->hit.triangle);

  // Leave by the clear share of an interface: a vertex that is seen from inside. What it reflects walks on in the body.
  // A path that came by an entry lobe is multiplied by the albedo of the exit lobe here, as the next walk has no entry.
  // A profile does not know from where the light comes to the interface.
  if (material.constants.spec_trans > 0 && !is_back && context.mode() != SubsurfaceMode::diffusion) [[unlikely]] {
    const VertexSamples u{sampler.draw(Dimension::exit_light, path->depth),
                          sampler.draw(Dimension::exit_bsdf, path->depth), path->walk.roulette};
    Vertex clear;
    const Ray arriving{path->ray.org, exit->direction, path->ray.tmax, path->ray.time};
    evaluate_surface(context, arriving, exit->hit, 0, &clear);
    if (u.bsdf[3] < clear.material.spec_trans) {
      clear.kind = Vertex::Kind::interface;
      clear.u = u;
      clear.material.metallic = clear.material.diff_trans = 0;
      clear.material.spec_trans = 1;
      path->ray = arriving;
      if (!is_within) path->throughput *= kMeanDiffuseTransmittance;
      if (record) record->leave_body(*clear.instance, exit->hit, clear.hit, path->throughput);
      const Meeting met = resolve_interface(context, sampler, &clear, path);
      path->throughput *= index_factor(index, path->media.indices());
      if (met == Meeting::replaced) path->pass(clear.origins[Vertex::kFacet].p, exit->direction);  // a ray meets it
      *v = clear;
      return met == Meeting::visible ? Exit::vertex : Exit::passes;
    }
  }
  if (may_cross) path->throughput *= index_factor(index, path->media.indices());

  // A surface below which light does not walk is opaque from below, too.
  if (!material.constants.scatters() ||
      (material.constants.metallic > 0 && !(value_at(context, *exit, &DisneyParameters::metallic) < 1))) {
    if (record) record->end("the light met an opaque surface from below");
    return Exit::none;
  }

  // Leave by the exit lobe: the lobes at the entry compensate for its albedo. Without an entry it is normalised
  // instead.
  if (is_within) path->throughput *= 1 / kMeanDiffuseTransmittance;
  const bool has_layers = material.constants.has_dimming_layers();
  DisneyLayers::Entered entered;
  if (has_layers) [[unlikely]]
    entered = layers_entered(entry, path->ray.dir);
  v->kind = Vertex::Kind::exit;
  v->instance = &instance;
  v->triangle = exit->hit;
  // Draw the random numbers while the triangle comes from memory.
  const Mesh& mesh = instance.prototype->mesh;
  v->u.light = control ? control->light_numbers : sampler.draw(Dimension::exit_light, path->depth);
  prefetch_corners(mesh, exit->hit.triangle, Attributes::normals);
  if (control && control->dome_sample)
    v->u.bsdf = {control->dome_sample->x, control->dome_sample->y};
  else
    v->u.bsdf = sampler.draw(Dimension::exit_bsdf, path->depth);
  v->u.roulette = path->walk.roulette;
  v->control.reset();
  v->moved.reset();
  const Placement& placement = instance.at(exit->hit, &v->moved);
  static_cast<SurfacePoint&>(v->hit) =
      on_side(surface_point(mesh, exit->hit, placement.object_to_world, placement.world_to_object), exit->direction);
  v->set_near_origins(v->hit.ns);
  v->is_mapped = material.normal_map.has_value();
  const auto full_hit = [&] { return surface_on_side(instance, placement, exit->hit, exit->direction); };
  v->frame = frame_from_normal(
      v->is_mapped ? mapped_normal(instance, placement, exit->hit, full_hit(), *material.normal_map) : v->hit.ns);
  v->exit_layers.reset();
  if (has_layers) [[unlikely]]
    v->exit_layers = layers_at(*v, *exit, is_within, entered);
  if (record) record->leave_body(instance, exit->hit, full_hit(), path->throughput);
  return Exit::vertex;
}

void find_own_wall(const PathContext& context, const Path& path, TriangleHit* hit) {
  const Interior* const medium = path.media.current();
  if (!medium || !medium->scatters || hit->instance == medium->instance) return;
  const Instance& met = context.scene.instance(hit->instance);
  const Instance& around = context.scene.instance(medium->instance);
  const DisneyMaterial& material = met.material(hit->triangle);
  if (!material.transmits() || material.constants.thin || is_wall_of(*medium, around, *hit, met)) return;
  std::optional<Placement> moved;
  const Placement& placement = met.at(*hit, &moved);
  if (interior_priority(met, placement, material.constants.priority, hit->instance) > medium->priority) return;
  const OwnWalls walls(context.scene, *medium);
  ++context.counters.bounce_rays;
  TriangleHit wall;
  if (context.scene.top->intersect(path.ray, &wall, &walls)) *hit = wall;
}

void drop_unresolved_distances(Vertex* v) {
  const float depth = depth_below_surface(v->hit, v->placement().object_to_world);
  Rgb& distance = v->material.scatter_distance;
  // Behind a clear surface there is no Lambert's law: such a channel is as dense as walks resolve.
  const bool clear = v->material.spec_trans > 0;
  const float least = least_resolved(depth);
  for (int c = 0; c < 3; ++c)
    if (!is_resolved(distance[c], depth)) distance[c] = clear ? least : 0;
}

bool is_within_medium(const PathContext& context, const Vertex& v, const Path& path) {
  const SubsurfaceBody* body = v.instance->body;
  if (!body || !v.material.scatters() || v.material.metallic == 1) return false;
  if (body->is_union()) [[unlikely]] {
    // The first hit of a path may be where its ray enters the union.
    if (path.depth == 0) return body->contains(path.ray);
    if (is_in_union(context.scene, path.media, *v.instance)) return true;
  }
  const uint8_t flags = body->members[v.instance->member].shells->flags(v.triangle.triangle);
  return !(flags & (MeshShells::kOpen | MeshShells::kInner)) &&
         body->leaves(v.instance->member, v.triangle, path.ray.dir);
}

}  // namespace alabaster
