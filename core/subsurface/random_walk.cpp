#include "core/subsurface/random_walk.h"

#include "core/diagnostics/check.h"
#include "core/math/frame.h"
#include "core/subsurface/body_tracers.h"
#include "core/subsurface/random_walk_loop.h"
#include "core/subsurface/walk_plan.h"

namespace alabaster {
namespace {

// The beginning of a walk in its body.
struct WalkBeginning {
  Vec3f p;  // in the space that walks are traced in
  WalkStart start;
  float depth = 0;      // world distance of p below the surface: medium that nothing was traced in
  Vec3f lobe{0, 0, 0};  // unit: where the entry lobe sends the walk, before it is mirrored into the body
};

Vec3f mirrored_into(const Vec3f& inward, const Vec3f& direction) {
  const float along = dot(direction, inward);
  return along >= 0 ? direction : direction - inward * (2 * along);
}

Vec3f sample_entry_lobe(const Vec3f& ns_inward, const Vec2f& u) {
  return frame_from_normal(ns_inward).to_world(sample_cosine_hemisphere(u));
}

// World distance of SubsurfaceBody::below() from the surface. A union is traced through one more transform, and its
// walks begin deeper.
float depth_of_beginning(const SubsurfaceBody& body, const SubsurfaceEntry& entry, const SubsurfaceBody::Maps& maps) {
  if (!body.is_union()) [[likely]]
    return depth_below_surface(entry.hit, maps.to_body);
  return surface_point(*body.members[entry.member].mesh, entry.triangle, maps.to_body, maps.to_object).offset;
}

WalkBeginning begin_walk(const SubsurfaceBody& body, const SubsurfaceEntry& entry, const SubsurfaceBody::Maps& maps,
                         const Vec2f& u) {
  // The paper's weights go on from the path's throughput, here relative to its largest channel.
  const Rgb relative = entry.throughput * (1 / max_component(entry.throughput));
  const ChannelValues throughput{relative.r, relative.g, relative.b};
  if (entry.within)  // there is no entry: the axis of guiding is the ray's
    return {body.to_walk_space(entry, entry.within->org), {entry.within->dir, entry.within->dir, throughput}};
  const Vec3f inward = -entry.hit.ng, lobe = sample_entry_lobe(-entry.ns, u);
  return {body.below(entry),
          {mirrored_into(inward, lobe), inward, throughput},
          depth_of_beginning(body, entry, maps),
          lobe};
}

// A walk that was mirrored into the body cannot be followed: the twin goes one segment along the lobe's direction.
void part_at_entry(const WalkBeginning& beginning, const WalkMedium& medium, const SubsurfaceNumbers& numbers) {
  ChannelValues throughput = beginning.start.throughput;
  for (size_t c = 0; c < 3; ++c)
    if (!medium.medium.active[c]) throughput[c] = 0;
  const ChromaticSegment segment(medium, throughput);
  const float t = segment.sample_distance({numbers.first()[2], numbers.first()[3]});
  beginning.start.twin->follow(segment, beginning.lobe, t, true);
}

// Distance from the surface to where the walk begins, along its direction. Grazing directions, which would have been
// long under way, count as if they rose by a sixteenth.
float entry_distance(const WalkBeginning& beginning, const SubsurfaceEntry& entry) {
  if (entry.within) return entry.gap;
  return beginning.depth / std::max(dot(beginning.start.direction, beginning.start.inward), 0x1p-4f);
}

// Through the inner side of an open shell.
bool enters_from_behind(const SubsurfaceBody& body, const SubsurfaceEntry& entry) {
  return !entry.within && body.leaves(entry.member, entry.triangle, -entry.hit.ng);
}

}  // namespace

Vec3f sample_entry_direction(const Vec3f& ns_inward, const Vec3f& ng_inward, const Vec2f& u) {
  return mirrored_into(ng_inward, sample_entry_lobe(ns_inward, u));
}

std::optional<SubsurfaceExit> RandomWalk::carry(const SubsurfaceBody& body, const SubsurfaceEntry& entry,
                                                SubsurfaceNumbers& numbers, RenderCounters& counters) const {
  CHECK(entry.medium);
  CHECK(contents || !body.occupied);
  const float scale = max_component(entry.throughput);
  if (!(scale > 0)) return std::nullopt;
  const float time = entry.triangle.time;
  std::optional<SubsurfaceBody::Maps> moved;
  const SubsurfaceBody::Maps& maps = body.members[entry.member].at(entry.triangle, &moved);
  WalkBeginning beginning = begin_walk(body, entry, maps, {numbers.first()[0], numbers.first()[1]});
  const WalkPlan plan = plan_walk(settings, body, entry);
  beginning.start.to_light = plan.to_light;
  WalkSettings used = settings;
  used.guiding = plan.guided, used.sphere_steps = plan.sphere_steps;
  std::optional<HalfSpaceTwin> follower;
  if (twin && plan.to_light == Vec3f(0, 0, 0)) {
    follower.emplace(entry.ns, *entry.medium);
    beginning.start.twin = &*follower;
    if (beginning.lobe != beginning.start.direction) part_at_entry(beginning, *entry.medium, numbers);
  }
  const auto walk = [&](auto tracer) {
    if (entry.within && used.guiding) {  // most such rays begin below a clear wall, a camera's anywhere
      typename decltype(tracer)::Hit behind{};
      ++counters.walk_rays;
      if (tracer.intersect(-entry.within->dir, std::numeric_limits<float>::infinity(), &behind))
        beginning.start.depth = tracer.exit_distance(behind);
    }
    if (!record) return run_walk(tracer, beginning.start, *entry.medium, used, numbers, counters);
    RecordingTracer recording(tracer, record);
    const auto end = run_walk(recording, beginning.start, *entry.medium, used, numbers, counters);
    if (end) record->push_back({WalkStep::Kind::exit, end->direction, recording.exit_distance(end->hit)});
    return end;
  };
  const float distance = entry_distance(beginning, entry);
  const auto end = body.is_union() ? walk(UnionTracer(body, {entry.member, beginning.p, distance,
                                                             enters_from_behind(body, entry), time, contents}))
                                   : walk(MeshTracer(body, {beginning.p, distance, maps.to_object, time}));
  if (follower)
    for (int c = 0; c < 3; ++c) (*twin)[c] = static_cast<float>(follower->throughput()[static_cast<size_t>(c)]) * scale;
  if (!end) return std::nullopt;
  SubsurfaceExit exit{end->hit, end->direction, {}, end->events};
  const uint32_t local = body.is_union() ? end->hit.instance : 0;
  const auto members = static_cast<uint32_t>(body.members.size());
  exit.is_content = local >= members;
  exit.hit.instance =
      exit.is_content ? body.contents[local - members] : body.members[local].instance_of(entry.triangle);
  for (int c = 0; c < 3; ++c) exit.throughput[c] = static_cast<float>(end->throughput[static_cast<size_t>(c)]) * scale;
  return exit;
}

}  // namespace alabaster
