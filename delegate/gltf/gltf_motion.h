// Motion over the shutter: prims at several times, as samples of those at the frame's own.
#pragma once

#include <functional>

#include "delegate/gltf/gltf_report.h"
#include "delegate/gltf/gltf_scene.h"

namespace alabaster::hd::gltf {

inline constexpr int kShutterSamples = 5;

/// Gives `prims`, which move or deform, their samples over the shutter of `options`. `pose_at` makes the same prims as
/// they are that many seconds after the frame's own time. A prim that is not there at all times, or not placed alike,
/// gets no samples (reported).
void sample_motion(const GltfOptions& options, const std::function<GltfPrims(double)>& pose_at, GltfPrims* prims,
                   Report& report);

}  // namespace alabaster::hd::gltf
