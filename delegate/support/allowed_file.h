// The files that a scene file may name, for reading and for writing: those in its own folder or below. A scene from a
// stranger then neither reads nor replaces what did not come with it.
#pragma once

#include <string>

namespace alabaster::hd::support {

/// Nothing if `file` lies in `folder` or below, with the symbolic links of both followed; else the reason with its
/// remedy. The file need not exist. An empty folder is the working folder.
std::string OutsideFault(const std::string& folder, const std::string& file);

}  // namespace alabaster::hd::support
