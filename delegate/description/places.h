// Where a description puts its models, meshes, lights and camera.
#pragma once

#include "delegate/description/load_state.h"

namespace alabaster::hd::description {

// The keys of a place, of which an entry has one at most.
inline constexpr const char* kPlacements[] = {"transform", "lookAt", "motion"};

// These throw LoadFailed after a report.
/// The place that an entry's `transform`, `lookAt` or `motion` says.
Placement placement_of(LoadState& load, const std::string& pointer, const nlohmann::json& entry);
/// The frame at `eye` that looks at `target`; `up` leans it: null: the scene's.
Matrix4d aimed_at(LoadState& load, const std::string& pointer, const Vec3d& eye, const Vec3d& target,
                  const nlohmann::json* up);
/// The samples of a "motion", at increasing times.
TimeSamples<Matrix4d> to_motion(LoadState& load, const std::string& pointer, const nlohmann::json& motion);

/// Places a prim, after where it is itself. What an instancer places goes with it, so it stays as it is.
void place_prim(const Matrix4d& transform, host::PrimDescription* prim);
/// Lets a prim move through the world by what `motion` does from time 0 on, after what it does itself; lights, and what
/// an instancer places, stay as they are.
void move_prim(const TimeSamples<Matrix4d>& motion, host::PrimDescription* prim);

}  // namespace alabaster::hd::description
