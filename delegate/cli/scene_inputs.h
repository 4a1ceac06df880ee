// The files that a loaded scene was read from.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "delegate/cli/scene_session.h"

namespace alabaster::cli {

/// The scene's own file, and the files of its models, images and lights: those of a set of images one by one. Without
/// the colour configuration.
std::set<std::string> scene_files(const SceneSession& session, const std::string& scene);

/// The error message if one of `outputs` is a file that the session has read, under whatever name; else empty.
std::string input_overwritten(const std::vector<std::string>& outputs, const SceneSession& session,
                              const std::string& scene);

}  // namespace alabaster::cli
