// Meshes of equal geometry, which are built once.
#pragma once

#include <memory>
#include <vector>

#include "delegate/prims/mesh_build.h"

namespace alabaster::hd::prims {

using MeshJobs = std::vector<std::shared_ptr<const MeshJob>>;

/// Returns, for each job of `to_build`, the index of the first job with bitwise equal geometry; material slots may
/// differ. Indices below built.size() refer to `built`, the others, less built.size(), to `to_build`. A job without an
/// equal one gets its own index. Jobs are compared by digest if their numbers of faces, corners and points are equal. A
/// mesh with edited points equals no other. Throws BuildCancelled.
std::vector<size_t> find_equal_meshes(const MeshJobs& built, const MeshJobs& to_build, const CancelToken& cancel);

}  // namespace alabaster::hd::prims
