// The motion of a description's models, meshes and camera.
#pragma once

#include "delegate/description/load_state.h"

namespace alabaster::hd::description {

/// The samples of a "motion", which the schema has accepted. Throws LoadFailed after a report: a transform cannot be
/// inverted, or times do not increase.
TimeSamples<Matrix4d> to_motion(LoadState& load, const std::string& pointer, const nlohmann::json& motion);

/// The transform at a time; of at least one sample.
Matrix4d transform_at(const TimeSamples<Matrix4d>& samples, double time);

/// Places a prim, after where it is itself. What an instancer places goes with it, so it stays as it is.
void place_prim(const Matrix4d& transform, host::PrimDescription* prim);
/// Lets a prim move through the world by what `motion` does from time 0 on, after what it does itself; lights, and what
/// an instancer places, stay as they are.
void move_prim(const TimeSamples<Matrix4d>& motion, host::PrimDescription* prim);

}  // namespace alabaster::hd::description
