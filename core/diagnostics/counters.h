// Counts of what rendering did: one plain struct per worker, added up when a pass ends.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <tuple>

namespace alabaster {

/// One camera sample of a frame: all that its random numbers depend on beside frame and seed.
struct SampleAddress {
  int32_t x = 0, y = 0;  // pixel, y-down
  uint32_t sample = 0;   // of the pixel

  /// The order in which an even frame takes them.
  bool operator<(const SampleAddress& o) const { return std::tie(sample, y, x) < std::tie(o.sample, o.y, o.x); }
  bool operator==(const SampleAddress&) const = default;
};

/// Where on its path a sample ceased to be finite.
enum class NonfiniteCause { emission, light, lobe, walk, exposure, other };
/// By cause: light that a ray met; a light that was sampled; a lobe and its pdf; a walk below a surface; the camera's
/// exposure; a sum of finite numbers, or what no vertex shows.
inline constexpr const char* kNonfiniteCauses[] = {"emission", "light", "lobe", "walk", "exposure", "other"};

struct RenderCounters {
  uint64_t camera_rays = 0;
  uint64_t bounce_rays = 0;
  uint64_t shadow_rays = 0;
  uint64_t walk_rays = 0;   // segments of subsurface walks that were traced
  uint64_t probe_rays = 0;  // of normalized diffusion, and of the test for thick bodies
  uint64_t probe_hits = 0;  // surfaces that they met
  uint64_t walks = 0;
  uint64_t walk_events = 0;        // scattering events
  uint64_t walk_sphere_steps = 0;  // jumps through the interior: each stands for many events
  uint64_t walk_exits = 0;
  uint64_t walk_roulette_ends = 0;
  uint64_t walk_lost = 0;          // walks that left an open mesh through a hole: their energy is lost
  uint64_t walk_safety_cap = 0;    // walks ended by the safety cap: must stay zero
  uint64_t rejected_rays = 0;      // rays that were not finite and never reached Embree
  uint64_t nonfinite_samples = 0;  // samples whose radiance was not finite: dropped, and counted here
  std::array<uint64_t, std::size(kNonfiniteCauses)> nonfinite_causes{};  // of those
  std::optional<SampleAddress> first_nonfinite;                          // the first of those
  uint64_t samples = 0;
  double max_walk_weight = 0;
  double walk_lost_energy = 0;  // of what was lost in walks, each walk counting 1: over walks, the share that is lost

  uint64_t rays() const { return camera_rays + bounce_rays + shadow_rays + walk_rays + probe_rays; }

  /// The first stays, whichever thread meets it when.
  void note_nonfinite(const SampleAddress& at, NonfiniteCause cause) {
    ++nonfinite_samples;
    ++nonfinite_causes[static_cast<size_t>(cause)];
    if (!first_nonfinite || at < *first_nonfinite) first_nonfinite = at;
  }

  void add(const RenderCounters& o);
};

/// Those that are added up. A new one has its member and its row.
struct CounterRow {
  uint64_t RenderCounters::*member;
  const char* name;  // in the delegate's statistics; empty: they do not show it
};
inline constexpr CounterRow kCounters[] = {
    {&RenderCounters::camera_rays, "rays.camera"},
    {&RenderCounters::bounce_rays, "rays.bounce"},
    {&RenderCounters::shadow_rays, "rays.shadow"},
    {&RenderCounters::walk_rays, "rays.walk"},
    {&RenderCounters::probe_rays, "rays.probe"},
    {&RenderCounters::probe_hits, "probe.hits"},
    {&RenderCounters::walks, "walk.count"},
    {&RenderCounters::walk_events, "walk.events"},
    {&RenderCounters::walk_sphere_steps, ""},
    {&RenderCounters::walk_exits, "walk.exits"},
    {&RenderCounters::walk_roulette_ends, ""},
    {&RenderCounters::walk_lost, "walk.lost"},
    {&RenderCounters::walk_safety_cap, "walk.safetyCap"},
    {&RenderCounters::rejected_rays, "rejectedRays"},
    {&RenderCounters::nonfinite_samples, "nonfiniteSamples"},
    {&RenderCounters::samples, ""},
};

inline void RenderCounters::add(const RenderCounters& o) {
  for (const CounterRow& row : kCounters) this->*row.member += o.*row.member;
  for (size_t i = 0; i < nonfinite_causes.size(); ++i) nonfinite_causes[i] += o.nonfinite_causes[i];
  if (o.first_nonfinite && (!first_nonfinite || *o.first_nonfinite < *first_nonfinite))
    first_nonfinite = o.first_nonfinite;
  max_walk_weight = std::max(max_walk_weight, o.max_walk_weight);
  walk_lost_energy += o.walk_lost_energy;
}

}  // namespace alabaster
