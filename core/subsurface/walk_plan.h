// How a walk is sampled: it decides noise and time alone (random_walk.md).
#pragma once

#include "core/subsurface/body.h"
#include "core/subsurface/random_walk.h"

namespace alabaster {

struct WalkPlan {
  bool guided = false;        // by Dwivedi sampling: to the light, else back to the surface
  bool sphere_steps = false;  // where the tracer bounds distances
  Vec3f to_light{0, 0, 0};    // unit; zero: walks are not guided to light. Such walks have no twin
};

/// `entry.medium` must be set.
WalkPlan plan_walk(const WalkSettings& settings, const SubsurfaceBody& body, const SubsurfaceEntry& entry);

/// The shortcuts that walks in a member may take, whatever its medium.
WalkShortcuts possible_shortcuts(const WalkSettings& settings, const SubsurfaceBody& body, uint32_t member);

}  // namespace alabaster
