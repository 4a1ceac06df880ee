// Time samples of the contract, checked.
#pragma once

#include "core/math/motion.h"
#include "delegate/api/scene_types.h"
#include "delegate/prims/diagnostics.h"

namespace alabaster::hd::prims {

/// The fault of the times of samples; empty if there is none.
std::string times_fault(const std::vector<double>& times, size_t values);

/// The samples of a transform; empty where it stands still, and where they are faulty (reported).
alabaster::TimeSamples<Matrix4d> checked_motion(const hd::TimeSamples<Matrix4d>& samples, const Path& where,
                                                const alabaster::DiagnosticSink& sink);

}  // namespace alabaster::hd::prims
