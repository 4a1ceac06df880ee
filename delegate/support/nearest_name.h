// The nearest known name to a wrong one, for messages that ask "did you mean ...?".
#pragma once

#include <string>
#include <vector>

namespace alabaster::hd::support {

/// The name in `known` with the smallest edit distance to `name`, of which wrong case counts half a wrong letter; empty
/// if none is near: within two letters, or within a third of them for names longer than six.
std::string NearestName(const std::string& name, const std::vector<std::string>& known);

}  // namespace alabaster::hd::support
