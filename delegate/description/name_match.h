// Names as people type them: globs over prims, and what to say about a wrong one.
#pragma once

#include <string>
#include <vector>

#include "delegate/api/types.h"

namespace alabaster::hd::description {

/// " Did you mean 'roughness'?" or, with no name near enough, nothing.
std::string suggestion(const std::string& name, const std::vector<std::string>& candidates);

/// The name that the author of a model gave: of "/gltf/bust/materials/2_skin" it is "skin", of the mesh primitive
/// "/gltf/bust/nodes/3_head/0" it is "head".
std::string authored_name(const Path& path, bool is_mesh);

/// Whether `pattern` (glob: * ?) means this prim: by its path, its last component, or its authored name.
bool matches(const std::string& pattern, const Path& path, bool is_mesh);

}  // namespace alabaster::hd::description
