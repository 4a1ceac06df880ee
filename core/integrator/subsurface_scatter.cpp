#include "core/integrator/subsurface_scatter.h"

#include "core/diagnostics/check.h"
#include "core/integrator/boundary.h"
#include "core/integrator/direct_light.h"
#include "core/integrator/path_record.h"
#include "core/integrator/see_through.h"
#include "core/integrator/shading_normal.h"
#include "core/material/disney_layers.h"
#include "core/sampling/warp.h"
#include "core/scene/clear_bodies.h"
#include "core/subsurface/body.h"
#include "core/subsurface/normalized_diffusion.h"

namespace alabaster {
namespace {

/// The medium of a vertex: made at commit if no texture varies it and every distance can be resolved, else in `made`.
const WalkMedium* medium_at(const PathVertex& v, const IntegratorSettings& settings, std::optional<WalkMedium>* made) {
  CHECK(v.instance->body);
  CHECK_LT(v.instance->member, v.instance->body->members.size());
  const auto& member = v.instance->body->members[v.instance->member];
  const size_t slot = v.instance->slot(v.triangle.triangle);
  const DisneyParameters& p = v.material;
  if (member.media[slot] && p.scatter_distance == v.instance->materials[slot]->constants.scatter_distance)
    return &(*member.media[slot])[settings.inversion];
  const WalkShortcuts shortcuts{settings.walk.guiding && member.room_to_guide,
                                settings.walk.sphere_steps && member.distances};
  return &made->emplace(make_medium(p.base_color, p.scatter_distance, settings.inversion, p.scatter_anisotropy),
                        shortcuts);
}

SubsurfaceEntry entry_at(const VertexBelow& below, const PathState& path) {
  const PathVertex& v = below.vertex;
  SubsurfaceEntry entry{v.triangle, v.instance->member, v.hit, v.frame.n, path.throughput, &below.medium()};
  if (below.within) entry.within = path.ray;
  return entry;
}

template <SubsurfaceMode kMode>
std::optional<SubsurfaceExit> carry(const PathContext& context, const PixelSampler& sampler,
                                    const SubsurfaceEntry& entry, const SubsurfaceBody& body, const PathState& path,
                                    Rgb* twin) {
  if constexpr (kMode == SubsurfaceMode::diffusion) {
    SubsurfaceNumbers numbers(sampler, Dimension::subsurface, path.depth);
    return NormalizedDiffusion{}.carry(body, entry, numbers, context.counters);
  }
  SubsurfaceNumbers numbers(sampler, Dimension::subsurface, path.depth);
  return RandomWalk{context.settings.walk, context.record ? context.record->walk() : nullptr, twin}.carry(
      body, entry, numbers, context.counters);
}

Vec2f onward_numbers(const PixelSampler& sampler, const std::optional<FlatExit>& flat, uint32_t depth) {
  if (flat && flat->onward) return *flat->onward;
  const auto u = sampler.draw(Dimension::exit_bsdf, depth);
  return {u[0], u[1]};
}

/// An exit, and the entry that the walk began with.
struct Leaving {
  const SubsurfaceExit& exit;
  const Instance& instance;        // of the exit
  const DisneyMaterial& material;  // of the exit
  const VertexBelow& below;
  Rgb index;  // of the interior from which the path entered
};

/// The normal of the exit lobe.
Vec3f exit_normal(const Leaving& leaving, const Placement& placement, const SurfacePoint& at) {
  const std::optional<NormalMap>& map = leaving.material.normal_map;
  if (!map) return at.ns;
  const TriangleHit& hit = leaving.exit.hit;
  return mapped_normal(leaving.instance, placement, hit,
                       surface_on_side(leaving.instance, placement, hit, leaving.exit.direction), *map);
}

/// The layers over an exit.
struct ExitLayers {
  DisneyLayers layers;
  DisneyLayers::Entered entered;  // where the path entered
  float leaving(const Vec3f& wi) const { return layers.leaving(wi, entered); }
};

/// The layers that the path passed where it entered, along `dir`. A path that began within passed none: those of the
/// `exit` are as if its light came from everywhere.
DisneyLayers::Entered layers_entered(const Leaving& leaving, const Vec3f& dir, const DisneyLayers& exit) {
  const PathVertex& v = leaving.below.vertex;
  if (leaving.below.within) return exit.from_within();
  const bool inside = v.boundary.inside && !v.boundary.open;
  const auto layers = inside ? std::nullopt : DisneyLayers::of(v.material);
  return layers ? layers->entered(v.frame.to_local(-dir)) : DisneyLayers::Entered();
}

/// Empty: the material of the exit has none. `dir`: along which the path entered; `frame`: of the exit lobe.
std::optional<ExitLayers> layers_at(const Leaving& leaving, const Vec3f& dir, const Placement& placement,
                                    const Frame& frame) {
  const SubsurfaceExit& exit = leaving.exit;
  const Instance& instance = leaving.instance;
  const DisneyMaterial& material = leaving.material;
  if (!material.constants.has_dimming_layers()) [[likely]]
    return std::nullopt;
  const SurfaceHit hit = surface_on_side(instance, placement, exit.hit, exit.direction);
  DisneyParameters p = material.evaluate({instance.prototype->mesh, exit.hit, hit.uv});
  const auto& map = material.coat_normal_map;
  if (map || material.normal_map)
    p.coat_normal = frame.to_local(map ? mapped_normal(instance, placement, exit.hit, hit, *map) : hit.ns);
  const auto layers = DisneyLayers::of(p);
  return layers ? std::optional(ExitLayers{*layers, layers_entered(leaving, dir, *layers)}) : std::nullopt;
}

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

/// The interiors on the outer side of an exit. The walk crosses no surface of the clear bodies that touch its own body,
/// so they are found by a ray. The inside of an open surface cannot be found so: its interior stays as at the entry.
Interiors interiors_beyond(const PathContext& context, const SubsurfaceExit& exit, const SubsurfaceBody& body,
                           const PathState& path) {
  Interiors beyond;
  const auto enter_those = [&](const Interiors& all, bool closed) {
    for (uint32_t i = 0; i < all.size(); ++i)
      if (context.scene.instance(all[i].instance).prototype->mesh.closed == closed) beyond.enter(all[i]);
  };
  enter_those(path.interiors, false);
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
  for (uint32_t i = 0; i < path.hollows.size(); ++i) {
    const SubsurfaceBody* const hollow = context.scene.instance(path.hollows[i]).body;
    if (hollow && hollow->is_union())
      for (const auto& member : hollow->members) beyond.leave(member.instance);
    else
      beyond.leave(path.hollows[i]);
  }
  for (const auto& member : body.members) beyond.leave(member.instance_of(exit.hit));
  return beyond;
}

float clear_share(const PathContext& context, const TriangleHit& hit) {
  return context.scene.instance(hit.instance).material(hit.triangle).constants.spec_trans;
}

/// Sets path->interiors to those beyond *exit. Where the index falls from the entry to the exit, the share (low /
/// high)^2 of the walks passes, and the others come out at the entry: *exit becomes it (random_walk.md, "Clear bodies
/// that touch"). For lobes at both ends.
void cross_to_interiors(const PathContext& context, const PixelSampler& sampler, const VertexBelow& below,
                        PathState* path, SubsurfaceExit* exit) {
  const PathVertex& v = below.vertex;
  const Interiors beyond = interiors_beyond(context, *exit, *v.instance->body, *path);
  const float share = sqr(beyond.index() / path->interiors.index());
  const auto u = sampler.draw(Dimension::exit_bsdf, path->depth);  // leave_clear_surface() takes the last one
  if (share < 1 && !below.within && u[3] >= clear_share(context, exit->hit) && u[2] >= share) {
    exit->hit = v.triangle;
    exit->direction = v.hit.ng;
  } else {
    path->interiors = beyond;
  }
}

/// The exit lobe: light sampling, and the direction in which the path goes on. The albedo of the lobe is
/// kMeanDiffuseTransmittance. The lobes at the entry compensate for that; for a walk without an entry the exit lobe is
/// normalised instead. path->throughput: of the exit, with the factor of the indices.
bool leave_surface(const PathContext& context, const PixelSampler& sampler, const Leaving& leaving, PathState* path) {
  const SubsurfaceExit& exit = leaving.exit;
  const Instance& instance = leaving.instance;
  const std::optional<FlatExit>& flat = leaving.below.flat;
  if (leaving.below.within) path->throughput *= 1 / kMeanDiffuseTransmittance;
  // Draw the random numbers while the triangle comes from memory.
  const Mesh& mesh = instance.prototype->mesh;
  const auto u_light = flat ? flat->numbers : sampler.draw(Dimension::exit_light, path->depth);
  prefetch_corners(mesh, exit.hit.triangle, Attributes::normals);
  const auto u_onward = onward_numbers(sampler, flat, path->depth);
  std::optional<Placement> moved;
  const Placement& placement = instance.at(exit.hit, &moved);
  const SurfacePoint hit =
      on_side(surface_point(mesh, exit.hit, placement.object_to_world, placement.world_to_object), exit.direction);
  const bool mapped = leaving.material.normal_map.has_value();
  const Vec3f n = exit_normal(leaving, placement, hit);
  const Frame frame = frame_from_normal(n);
  const Departure departure = depart(mesh, placement.object_to_world, exit.hit, hit, hit.ns);
  const auto layers = layers_at(leaving, path->ray.dir, placement, frame);
  const auto exit_lobe = [&](const Vec3f& wi) -> ScatterValue {
    const float cosine = dot(wi, frame.n);
    if (!(cosine > 0) || (mapped && !(dot(wi, hit.ns) > 0))) return {};
    ScatterValue value{Rgb(eval_subsurface_exit({0, 0, cosine}) * cosine), cosine * kInvPi};
    if (layers) [[unlikely]]
      value.f_cos *= layers->leaving(frame.to_local(wi));
    return value;
  };
  PathRecord* const record = context.record;
  if (record)
    record->leave_body(instance, exit.hit, surface_on_side(instance, placement, exit.hit, exit.direction),
                       path->throughput);
  const auto recorded_lobe = [&](const Vec3f& wi) {
    const ScatterValue value = exit_lobe(wi);
    if (record) record->sample_light(wi, value.f_cos, value.pdf);
    return value;
  };
  Rgb direct(0.0f);
  path->search = {ConstantDomes::bsdf_sampling_only, n};
  path->lights = &context.scene.lights_of(instance);
  for_direct_light(context, departure, {*path->lights, u_light, path->search, &path->interiors}, recorded_lobe,
                   [&](const ScatterValue&, const Rgb& arriving, LightWeight weight) {
                     const Rgb light = path->through_interiors(arriving, weight.distance);
                     direct += light;
                     if (record) record->light_arrives(path->throughput * light, weight);
                   });
  path->radiance += path->throughput * direct;

  const Vec3f wi = frame.to_world(sample_cosine_hemisphere(u_onward));
  const ScatterValue value = exit_lobe(wi);
  if (!(value.pdf > 0) && record) record->end("the exit lobe gave no direction");
  if (!(value.pdf > 0)) return false;
  path->throughput *= value.f_cos * (1 / value.pdf);
  path->scatter_pdf = value.pdf;
  path->go_on(origin_of(context, departure, wi), wi);
  return true;
}

/// An exit through the clear share of a boundary: a vertex that is seen from inside. Light that it reflects walks on in
/// the body. Empty: the exit lobe has the light, as it has the share 1 - specTrans. A path that came by an entry lobe
/// is multiplied by the albedo of the exit lobe here: the next walk has no entry.
std::optional<bool> leave_clear_surface(const PathContext& context, const PixelSampler& sampler, const Leaving& leaving,
                                        PathState* path) {
  const SubsurfaceExit& exit = leaving.exit;
  if (!(leaving.material.constants.spec_trans > 0)) [[likely]]
    return std::nullopt;
  Ray ray = path->ray;
  ray.dir = exit.direction;
  PathVertex v = make_vertex(context, ray, exit.hit);
  VertexNumbers numbers{sampler.draw(Dimension::exit_light, path->depth),
                        sampler.draw(Dimension::exit_bsdf, path->depth)};
  if (!(numbers.bsdf[3] < v.material.spec_trans)) return std::nullopt;
  path->ray = ray;
  v.material.metallic = v.material.diff_trans = 0;
  v.material.spec_trans = 1;
  path->throughput = exit.throughput;
  if (!leaving.below.within) path->throughput *= kMeanDiffuseTransmittance;
  if (PathRecord* record = context.record) record->leave_body(*v.instance, exit.hit, v.hit, path->throughput);
  const Vec3f within = v.departure.flat;
  const Meeting met = meet_boundary(context, sampler, &v, path, numbers.bsdf.data());
  path->throughput *= index_factor(leaving.index, path->interiors.indices());
  if (met == Meeting::boundary) return scatter_at_boundary(context, v, numbers, path, nullptr).has_value();
  if (met == Meeting::other) {  // the path's next ray meets it
    path->go_on(within, exit.direction);
    path->scatter_pdf = std::numeric_limits<float>::infinity();
  }
  return true;
}

}  // namespace

VertexBelow::VertexBelow(const PathVertex& v, const IntegratorSettings& settings, bool is_within)
    : vertex(v), within(is_within), medium_(medium_at(v, settings, &made_)) {}

template <SubsurfaceMode kMode>
bool scatter_below_surface(const PathContext& context, const PixelSampler& sampler, const VertexBelow& below,
                           PathState* path) {
  const SubsurfaceEntry entry = entry_at(below, *path);
  Rgb twin(0.0f);
  const bool has_twin = below.flat && !is_black(below.flat->light);
  // Where no walk is followed, the twin has its expectation.
  if (has_twin) DCHECK(below.medium().medium.albedo == below.vertex.material.base_color);
  if (has_twin) twin = entry.throughput * obtained_albedo(below.vertex.material.base_color, context.settings.inversion);
  const SubsurfaceBody& body = *below.vertex.instance->body;
  auto exit = carry<kMode>(context, sampler, entry, body, *path, has_twin ? &twin : nullptr);
  path->twin_light = has_twin ? twin * below.flat->light * -1.0f : Rgb(0.0f);
  path->radiance += path->twin_light;
  if (context.record && has_twin) context.record->twin_leaves(path->twin_light);
  if (!exit && context.record) context.record->end("the light did not leave the body");
  if (!exit) return false;
  path->walk_events = exit->events;
  path->throughput = exit->throughput;
  Rgb index(1.0f);  // of the interior from which the path entered
  if (!path->interiors.empty() || !body.touched.empty()) [[unlikely]] {
    index = path->interiors.indices();
    cross_to_interiors(context, sampler, below, path, &*exit);
    path->throughput *= index_factor(index, path->interiors.indices());
  }
  // The walk has left the union's medium, so the path is not in its hollow any more.
  if (body.is_union() && !path->hollows.empty()) [[unlikely]]
    path->hollows.leave(body.members.front().instance);
  const Instance& instance = context.scene.instance(exit->hit.instance);
  const Leaving leaving{*exit, instance, instance.material(exit->hit.triangle), below, index};
  // A profile does not know from where the light comes to the boundary.
  if (kMode != SubsurfaceMode::diffusion)
    if (const auto left = leave_clear_surface(context, sampler, leaving, path)) return *left;
  return leave_surface(context, sampler, leaving, path);
}

template bool scatter_below_surface<SubsurfaceMode::walk>(const PathContext&, const PixelSampler&, const VertexBelow&,
                                                          PathState*);
template bool scatter_below_surface<SubsurfaceMode::diffusion>(const PathContext&, const PixelSampler&,
                                                               const VertexBelow&, PathState*);

void find_own_wall(const PathContext& context, const PathState& path, TriangleHit* hit) {
  const Interior* const medium = path.interiors.current();
  if (!medium || !medium->scatters || hit->instance == medium->instance) return;
  const Instance& met = context.scene.instance(hit->instance);
  const Instance& around = context.scene.instance(medium->instance);
  const DisneyMaterial& material = met.material(hit->triangle);
  if (!material.transmits() || material.constants.thin || is_wall_of(*medium, around, *hit, met)) return;
  if (clear_priority(met, material.constants.priority) > medium->priority) return;
  const OwnWalls walls(context.scene, *medium);
  ++context.counters.bounce_rays;
  TriangleHit wall;
  if (context.scene.top->intersect(path.ray, &wall, &walls)) *hit = wall;
}

void drop_unresolved_distances(PathVertex* v) {
  const float depth = depth_below_surface(v->hit, v->placement().object_to_world);
  Rgb& distance = v->material.scatter_distance;
  for (int c = 0; c < 3; ++c)
    if (!is_resolved(distance[c], depth)) distance[c] = 0;
}

bool is_within_medium(const PathContext& context, const PathVertex& v, const PathState& path) {
  const SubsurfaceBody* body = v.instance->body;
  if (!body || !v.material.scatters() || v.material.metallic == 1) return false;
  if (body->is_union()) [[unlikely]] {
    // The first hit of a path may be where its ray enters the union.
    if (path.depth == 0) return body->contains(path.ray);
    if (is_in_union(context.scene, path.interiors, *v.instance)) return true;
  }
  const uint8_t flags = body->members[v.instance->member].shells->flags(v.triangle.triangle);
  return !(flags & (MeshShells::kOpen | MeshShells::kInner)) &&
         body->leaves(v.instance->member, v.triangle, path.ray.dir);
}

}  // namespace alabaster
