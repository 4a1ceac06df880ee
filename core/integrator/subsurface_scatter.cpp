#include "core/integrator/subsurface_scatter.h"

#include "core/integrator/direct_light.h"
#include "core/material/disney_bsdf.h"
#include "core/sampling/warp.h"
#include "core/subsurface/lambert_limit.h"
#include "core/subsurface/normalized_diffusion.h"

namespace alabaster {
namespace {

/// Where light that entered at a vertex leaves, whatever carried it there.
struct SubsurfaceExit {
  const Instance* instance = nullptr;
  TriangleHit hit;       // ids are of the instance's prototype
  Vec3f direction;       // unit, world: from inside towards the surface
  Rgb throughput{0.0f};  // of the path up to here, without the exit lobe
  uint32_t events = 0;   // scattering events: 0 crossed without scattering, 1, or 2 for all that is more
};

/// A profile stands for all numbers of events at once.
constexpr uint32_t kEventsOfProfile = 2;

/// Just below the vertex, in the space of the walk.
Vec3f below_surface(const PathVertex& v) {
  const WalkSet* set = v.instance->walk.set;
  if (!set) return offset_point(v.hit.p_object, -v.hit.ng_object, v.hit.offset_object);
  const WalkSet::Member& member = set->members[v.instance->member];
  const SurfaceHit hit = surface_hit(*member.mesh, v.triangle, member.to_set, member.to_object);
  return offset_point(hit.p, -v.hit.ng, hit.offset);
}

/// How deep that is, in world units. It is taken from object space for sets as well: nothing else is near at hand, and
/// it only has to be of that size.
float depth_below_surface(const PathVertex& v) {
  return std::abs(dot(v.instance->object_to_world.vector(v.hit.ng_object * v.hit.offset_object), v.hit.ng));
}

Vec3f render_to_walk(const Instance& instance, const Vec3f& p) {
  return instance.walk.set ? p - instance.walk.set->origin : instance.world_to_object.point(p);
}

bool leaves_shell(const PathVertex& v, const Vec3f& direction) {
  return leaves(v.instance->prototype->mesh, *v.instance->shells, v.triangle.triangle,
                v.instance->world_to_object.vector(direction));
}

WalkEntry walk_entry(const PathVertex& v, bool within, const PathState& path) {
  WalkEntry entry{below_surface(v), -v.hit.ng, frame_from_normal(-v.frame.n)};
  entry.depth = depth_below_surface(v);
  if (within) {
    // The viewer's side of the surface is the inner one.
    entry = {render_to_walk(*v.instance, path.ray.org), v.hit.ng, frame_from_normal(v.frame.n)};
    entry.direction = path.ray.dir;
  } else if (v.instance->walk.set) {
    entry.from_behind = leaves_shell(v, path.ray.dir);
  }
  return entry;
}

std::optional<SubsurfaceExit> walk_to_exit(const PathContext& context, const PixelSampler& sampler,
                                           const PathVertex& vertex, bool within, const PathState& path) {
  const Instance& instance = *vertex.instance;
  const Medium medium = make_medium(vertex.material.base_color, vertex.material.scatter_distance,
                                    context.settings.walk.inversion, vertex.material.scatter_anisotropy);
  const float scale = max_component(path.throughput);
  if (!(scale > 0)) return std::nullopt;
  WalkEntry entry = walk_entry(vertex, within, path);
  entry.throughput = path.throughput * (1 / scale);
  const auto u = sampler.draw(Dimension::subsurface, path.depth);
  Rng rng = sampler.stream(Dimension::subsurface, path.depth);
  const auto exit =
      random_walk(instance.walk, entry, medium, context.settings.walk, {u[0], u[1]}, rng, context.counters);
  if (!exit) return std::nullopt;
  const Instance* left = &instance;
  if (const WalkSet* set = instance.walk.set)
    left = &context.scene.instances[set->members[exit->hit.instance].instance];
  return SubsurfaceExit{left, exit->hit, exit->direction, exit->throughput * scale, exit->events};
}

std::optional<SubsurfaceExit> diffuse_to_exit(const PathContext& context, const PixelSampler& sampler,
                                              const PathVertex& v, const PathState& path) {
  const Instance& instance = *v.instance;
  const DiffusionSpace space{instance.prototype->object.get(), &instance.prototype->mesh, instance.world_to_object};
  const DiffusionEntry entry{v.triangle,
                             v.hit.p_object,
                             v.hit.ng,
                             v.hit.ng_object,
                             v.hit.offset,
                             path.throughput,
                             v.material.base_color,
                             v.material.scatter_distance};
  Rng rng = sampler.stream(Dimension::subsurface, path.depth);
  const auto exit =
      sample_diffusion_exit(space, entry, sampler.draw(Dimension::subsurface, path.depth), rng, context.counters);
  if (!exit) return std::nullopt;
  Vec3f outward = exit->outward;
  if (const MeshShells* shells = instance.shells; shells && !(shells->flags(exit->hit.triangle) & MeshShells::kOpen))
    if (!leaves(*space.mesh, *shells, exit->hit.triangle, instance.world_to_object.vector(outward))) outward = -outward;
  return SubsurfaceExit{&instance, exit->hit, outward, exit->throughput, kEventsOfProfile};
}

/// Whether a ray of the entry's cosine lobe crosses `depth` without meeting the object's surface.
bool is_thick(const PathContext& context, const PathVertex& v, float depth, const Vec2f& u) {
  const Instance& instance = *v.instance;
  const Vec3f direction = frame_from_normal(-v.hit.ng).to_world(sample_cosine_hemisphere(u));
  const Ray ray{offset_point(v.hit.p_object, -v.hit.ng_object, v.hit.offset_object),
                instance.world_to_object.vector(direction), depth};
  ++context.counters.probe_rays;
  TriangleHit hit;
  return !instance.prototype->object->intersect(ray, &hit);
}

/// Where a pixel cannot tell them apart the walk is replaced by a Lambert reflection of the same energy: an exit at the
/// entry. Both branches have weight one: the picture is their blend.
std::optional<SubsurfaceExit> lambert_or_walk(const PathContext& context, const PixelSampler& sampler,
                                              const PathVertex& v, const PathState& path) {
  const AlbedoInversion inversion = context.settings.walk.inversion;
  const Rgb& albedo = v.material.base_color;
  // Without g: the isotropic medium of the same A and d reaches as far (make_medium). What the other inversions obtain
  // is known for it alone.
  const LambertLimit limit = lambert_limit(make_medium(albedo, v.material.scatter_distance, inversion));
  const bool known = v.material.scatter_anisotropy == 0 || inversion == AlbedoInversion::exact;
  const float probability = known ? lambert_probability(path.footprint.cone.width, limit) : 0;
  if (probability > 0) {
    // Numbers of their own: what the walk does must not depend on what was asked here.
    const auto u = sampler.draw(Dimension::subsurface_rung, path.depth);
    if (u[0] < probability && is_thick(context, v, limit.opaque_depth * (1 + u[1]), {u[2], u[3]})) {
      ++context.counters.lambert_exits;
      const Rgb obtained(obtained_albedo(albedo.r, inversion), obtained_albedo(albedo.g, inversion),
                         obtained_albedo(albedo.b, inversion));
      return SubsurfaceExit{v.instance, v.triangle, v.hit.ng, path.throughput * obtained, kEventsOfProfile};
    }
  }
  return walk_to_exit(context, sampler, v, false, path);
}

template <SubsurfaceMode kMode>
std::optional<SubsurfaceExit> carry_to_exit(const PathContext& context, const PixelSampler& sampler,
                                            const PathVertex& entry, bool within, const PathState& path) {
  if constexpr (kMode == SubsurfaceMode::diffusion) return diffuse_to_exit(context, sampler, entry, path);
  if (kMode == SubsurfaceMode::automatic && !within) return lambert_or_walk(context, sampler, entry, path);
  return walk_to_exit(context, sampler, entry, within, path);
}

/// The exit lobe: light sampling, and the direction in which the path goes on.
bool leave_surface(const PathContext& context, const PixelSampler& sampler, const SubsurfaceExit& exit,
                   PathState* path) {
  path->throughput = exit.throughput;
  const SurfaceHit hit = surface_on_side(*exit.instance, exit.hit, exit.direction);
  const Frame frame = frame_from_normal(hit.ns);
  const Departure departure = depart(*exit.instance, exit.hit, hit, frame.n);
  const auto exit_lobe = [&](const Vec3f& wi) -> ScatterValue {
    const float cosine = dot(wi, frame.n);
    if (!(cosine > 0)) return {};
    return {Rgb(eval_subsurface_exit({0, 0, cosine}) * cosine), cosine * kInvPi};
  };
  path->radiance +=
      path->throughput * direct_light(context, departure, sampler.draw(Dimension::exit_light, path->depth), exit_lobe);

  const auto u = sampler.draw(Dimension::exit_bsdf, path->depth);
  const Vec3f wi = frame.to_world(sample_cosine_hemisphere({u[0], u[1]}));
  const ScatterValue value = exit_lobe(wi);
  if (!(value.pdf > 0)) return false;
  path->throughput *= value.f_cos * (1 / value.pdf);
  path->scatter_pdf = value.pdf;
  path->ray = {origin_of(context, departure, wi), wi};
  return true;
}

}  // namespace

template <SubsurfaceMode kMode>
bool scatter_below_surface(const PathContext& context, const PixelSampler& sampler, const PathVertex& entry,
                           bool within, PathState* path) {
  const auto exit = carry_to_exit<kMode>(context, sampler, entry, within, *path);
  if (!exit) return false;
  path->walk_events = exit->events;
  return leave_surface(context, sampler, *exit, path);
}

template bool scatter_below_surface<SubsurfaceMode::walk>(const PathContext&, const PixelSampler&, const PathVertex&,
                                                          bool, PathState*);
template bool scatter_below_surface<SubsurfaceMode::diffusion>(const PathContext&, const PixelSampler&,
                                                               const PathVertex&, bool, PathState*);
template bool scatter_below_surface<SubsurfaceMode::automatic>(const PathContext&, const PixelSampler&,
                                                               const PathVertex&, bool, PathState*);

void drop_unresolved_distances(PathVertex* v) {
  const float depth = depth_below_surface(*v);
  Rgb& distance = v->material.scatter_distance;
  for (int c = 0; c < 3; ++c)
    if (!is_resolved(distance[c], depth)) distance[c] = 0;
}

bool is_within_medium(const PathVertex& vertex, const PathState& path) {
  const Instance& instance = *vertex.instance;
  if (!instance.shells || !vertex.material.scatters() || vertex.material.metallic == 1) return false;
  // Of a set the first surface that is met may be one that the ray enters.
  if (instance.walk.set && path.depth == 0)
    return instance.walk.set->contains(render_to_walk(instance, path.ray.org), path.ray.dir, nullptr);
  return !(instance.shells->flags(vertex.triangle.triangle) & (MeshShells::kOpen | MeshShells::kInner)) &&
         leaves_shell(vertex, path.ray.dir);
}

}  // namespace alabaster
