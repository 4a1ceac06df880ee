// The files that a loaded scene was read from.
#pragma once

#include <string>
#include <vector>

#include "delegate/cli/scene_session.h"

namespace alabaster::cli {

/// The error message if one of `outputs` is a file that the session has read, under whatever name; else empty.
std::string input_overwritten(const std::vector<std::string>& outputs, const SceneSession& session,
                              const std::string& scene);

}  // namespace alabaster::cli
