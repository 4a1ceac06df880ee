// Names as people type them: globs over prims.
#pragma once

#include <string>
#include <vector>

#include "delegate/api/scene_types.h"

namespace alabaster::hd::description {

/// True if `pattern` (a glob with * and ?) matches the prim's path, its last component, or its authored name.
bool matches(const std::string& pattern, const Path& path, bool is_mesh);

/// The subsets of a mesh that `pattern` matches by their paths, as places in the topology. A pattern that matches the
/// mesh is not meant for its subsets.
std::vector<size_t> matching_subsets(const std::string& pattern, const MeshTopology& topology);

}  // namespace alabaster::hd::description
