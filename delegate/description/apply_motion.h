// The motion of a description's models, meshes and camera.
#pragma once

#include "delegate/description/load_state.h"

namespace alabaster::hd::description {

/// The samples of a "motion", which the schema has accepted. Throws LoadFailed after a report: a transform cannot be
/// inverted, or times do not increase.
TimeSamples<Matrix4d> to_motion(LoadState& load, const std::string& pointer, const nlohmann::json& motion);

/// The transform at a time; of at least one sample.
Matrix4d transform_at(const TimeSamples<Matrix4d>& samples, double time);

/// Lets the meshes and cameras among `prims` move through the world by what `motion` does from time 0 on, after what
/// they do themselves. The instancers of meshes move, with all that they place.
void move_prims(const std::vector<Path>& prims, const TimeSamples<Matrix4d>& motion,
                host::RetainedSceneDelegate* scene);

}  // namespace alabaster::hd::description
