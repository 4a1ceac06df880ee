#include "core/integrator/subsurface_scatter.h"

#include "core/integrator/direct_light.h"
#include "core/material/disney_bsdf.h"
#include "core/sampling/warp.h"

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

std::optional<SubsurfaceExit> walk_to_exit(const PathContext& context, const PixelSampler& sampler,
                                           const PathVertex& entry, const PathState& path) {
  const Instance& instance = *entry.instance;
  const Medium medium =
      make_medium(entry.material.base_color, entry.material.scatter_distance, context.settings.walk.inversion);
  const Frame inward = frame_from_normal(-entry.frame.n);
  const float scale = max_component(path.throughput);
  if (!(scale > 0)) return std::nullopt;
  const WalkEntry walk_entry{offset_point(entry.hit.p_object, -entry.hit.ng_object, entry.hit.offset_object),
                             -entry.hit.ng, inward, path.throughput * (1 / scale)};
  const auto u = sampler.draw(Dimension::subsurface, path.depth);
  Rng rng = sampler.stream(Dimension::subsurface, path.depth);
  const WalkSpace space{instance.prototype->object.get(), instance.world_to_object, instance.prototype->mesh.bounds};
  const auto exit = random_walk(space, walk_entry, medium, context.settings.walk, {u[0], u[1]}, rng, context.counters);
  if (!exit) return std::nullopt;
  return SubsurfaceExit{&instance, exit->hit, exit->direction, exit->throughput * scale, exit->events};
}

/// The exit lobe: light sampling, and the direction in which the path goes on.
bool leave_surface(const PathContext& context, const PixelSampler& sampler, const SubsurfaceExit& exit,
                   PathState* path) {
  path->throughput = exit.throughput;
  const SurfaceHit hit = surface_on_side(*exit.instance, exit.hit, exit.direction);
  const Frame frame = frame_from_normal(hit.ns);
  const Vec3f outer = offset_point(hit.p, hit.ng, hit.offset);
  const auto exit_lobe = [&](const Vec3f& wi) -> ScatterValue {
    const float cosine = dot(wi, frame.n);
    if (!(cosine > 0) || !(dot(wi, hit.ng) > 0)) return {};
    return {Rgb(eval_subsurface_exit({0, 0, cosine}) * cosine), cosine * kInvPi};
  };
  path->radiance +=
      path->throughput * direct_light(context, outer, sampler.draw(Dimension::exit_light, path->depth), exit_lobe);

  const auto u = sampler.draw(Dimension::exit_bsdf, path->depth);
  const Vec3f wi = frame.to_world(sample_cosine_hemisphere({u[0], u[1]}));
  const ScatterValue value = exit_lobe(wi);
  if (!(value.pdf > 0)) return false;
  path->throughput *= value.f_cos * (1 / value.pdf);
  path->scatter_pdf = value.pdf;
  path->ray = {outer, wi};
  return true;
}

}  // namespace

bool scatter_below_surface(const PathContext& context, const PixelSampler& sampler, const PathVertex& entry,
                           PathState* path) {
  const auto exit = walk_to_exit(context, sampler, entry, *path);
  if (!exit) return false;
  path->walk_events = exit->events;
  return leave_surface(context, sampler, *exit, path);
}

}  // namespace alabaster
