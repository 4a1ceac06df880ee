// The nearest known name to a wrong one, for messages that ask "did you mean ...?".
#pragma once

#include <string>
#include <vector>

namespace alabaster::hd::support {

/// Returns the name in `known` with the smallest edit distance to `name`; wrong case counts half a wrong letter. Empty
/// if none is near. Near is two letters, or a third of the letters for names longer than six.
std::string NearestName(const std::string& name, const std::vector<std::string>& known);

}  // namespace alabaster::hd::support
