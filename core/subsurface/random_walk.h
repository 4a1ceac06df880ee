// Path-traced subsurface scattering: Chiang, Kutz, Burley 2016, sections 2 and 3. random_walk.md has the theory.
//
// A walk enters through a cosine lobe, scatters by the Henyey-Greenstein phase function, and leaves where a segment
// meets the end of the medium. Distances are sampled for one channel, chosen in proportion to the throughput (the
// paper: times alpha); the balance heuristic combines the channels' estimators (one-sample MIS). Roulette
// on the largest channel ends walks: unbiased, without a bounce cap. A safety cap of 1e6 events guards against broken
// geometry and is counted.
#pragma once

#include "core/diagnostics/cancel.h"
#include "core/diagnostics/counters.h"
#include "core/subsurface/body.h"
#include "core/subsurface/entry_exit.h"
#include "core/subsurface/walk_contents.h"
#include "core/subsurface/walk_record.h"

namespace alabaster {

struct WalkSettings {
  bool guiding = true;       // Dwivedi guiding, where it pays; affects noise only
  bool sphere_steps = true;  // jumps through the interior, where they pay; their bias is below 3e-4 of the albedo
  bool twins = true;         // the integrator asks for RandomWalk::twin; affects noise only
  uint32_t safety_cap = 1000000;
  CancelToken cancel = {};  // a walk throws BuildCancelled within 4096 events
};

/// The direction in which light enters, unit, world: from the cosine hemisphere about `ns_inward`. The lobe's
/// directions that a tilted shading normal sends out of the body are mirrored in the surface: (1-.5F_V) already says
/// how much light enters, so the lobe's mass must stay one. Dropping them instead would darken smooth-shaded
/// silhouettes and break the white furnace.
Vec3f sample_entry_direction(const Vec3f& ns_inward, const Vec3f& ng_inward, const Vec2f& u);

/// The carrier by a random walk. Empty: absorbed, ended by roulette, or lost through an open mesh (counted).
struct RandomWalk {
  WalkSettings settings;
  WalkRecord* record = nullptr;  // null: nobody looks
  /// Takes what the walk's twin in a half-space brings out, like SubsurfaceExit::throughput; its expectation is the
  /// albedo times the throughput of the entry. Null: no twin. For isotropic scattering, and entries from outside.
  Rgb* twin = nullptr;
  WalkContents* contents = nullptr;  // not null where the body is occupied

  std::optional<SubsurfaceExit> carry(const SubsurfaceBody& body, const SubsurfaceEntry& entry,
                                      SubsurfaceNumbers& numbers, RenderCounters& counters) const;
};

}  // namespace alabaster
