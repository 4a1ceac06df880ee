// Meshes of equal geometry, which are built once.
#pragma once

#include <memory>
#include <vector>

#include "delegate/prims/mesh_build.h"

namespace alabaster::hd::prims {

using MeshJobs = std::vector<std::shared_ptr<const MeshJob>>;

/// For each job of `to_build` the first that is built as it is but for its material slots, to the bit: its number among
/// `built`, or built.size() and the number among `to_build`, which may be its own. Decided by a digest of all values
/// that the mesh is made of, for meshes that have as many faces, corners and points as another. Meshes whose points are
/// edited stand alone. Throws BuildCancelled.
std::vector<size_t> find_equal_meshes(const MeshJobs& built, const MeshJobs& to_build, const CancelToken& cancel);

}  // namespace alabaster::hd::prims
