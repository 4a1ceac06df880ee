// The values that --set changes in a scene, for command info.
#pragma once

#include <string>

namespace alabaster::cli {

/// An option --set that changes the prim `name` of `list` (materials, meshes or lights), and the names of all values
/// that can be set. Lines. Without a name `list` is "camera".
std::string override_lines(const std::string& list, const std::string& name);

}  // namespace alabaster::cli
