#include "core/subsurface/random_walk.h"

#include "core/subsurface/mesh_tracer.h"
#include "core/subsurface/random_walk_loop.h"

namespace alabaster {

WalkShortcuts useful_shortcuts(const Medium& medium, const WalkSettings& settings) {
  if (medium.g != 0) return {};
  float clearest = 2;  // of the channels' 1 - alpha
  bool guided = false;
  for (int c = 0; c < 3; ++c) {
    if (!medium.active[c]) continue;
    clearest = std::min(clearest, medium.one_minus_alpha[c]);
    guided |= DiffusionModes::is_guided(medium.one_minus_alpha[c]);
  }
  return {settings.guiding && guided && clearest > kGuidingPaysAbove,
          settings.sphere_steps && clearest < kSphereStepsPayBelow};
}

Vec3f sample_walk_entry(const WalkEntry& entry, const Vec2f& u) {
  const Vec3f direction = entry.frame_inward.to_world(sample_cosine_hemisphere(u));
  const float inward = dot(direction, entry.ng_inward);
  return inward >= 0 ? direction : direction - entry.ng_inward * (2 * inward);
}

namespace {

/// Distance from the surface to where the walk begins, along its direction. Grazing directions, which would have been
/// long under way, count as if they rose by a sixteenth.
float entry_distance(const WalkEntry& entry, const Vec3f& direction) {
  return entry.depth / std::max(dot(direction, entry.ng_inward), 0x1p-4f);
}

}  // namespace

std::optional<WalkExit> random_walk(const WalkSpace& space, const WalkEntry& entry, const Medium& medium,
                                    const WalkSettings& settings, const Vec2f& u_entry, Rng& rng,
                                    RenderCounters& counters) {
  const Rgb& t0 = entry.throughput;
  WalkSettings used = settings;
  used.guiding &= space.room_to_guide;
  const auto walk = [&](auto tracer) {
    const Vec3f direction = entry.direction ? *entry.direction : sample_walk_entry(entry, u_entry);
    tracer.start_below(entry_distance(entry, direction));
    return run_walk(tracer, {direction, entry.ng_inward, {t0.r, t0.g, t0.b}}, medium, used, rng, counters);
  };
  const auto end =
      space.set ? walk(SetTracer(*space.set, entry.p, entry.from_behind)) : walk(MeshTracer(space, entry.p));
  if (!end) return std::nullopt;
  const ChannelValues& t = end->throughput;
  return WalkExit{end->hit,
                  end->direction,
                  {static_cast<float>(t[0]), static_cast<float>(t[1]), static_cast<float>(t[2])},
                  end->events};
}

}  // namespace alabaster
