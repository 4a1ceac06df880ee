// Where libOpenImageDenoise may lie. Internal to this room.
#pragma once

#include <string>
#include <vector>

namespace alabaster {

/// The names to try in order, for dlopen: files that exist, and the bare name, which the system looks up. `named` is
/// the file or folder that the user names; empty if none. If it is named, nothing else is tried, and there may be none.
std::vector<std::string> find_oidn(const std::string& named);

}  // namespace alabaster
