// The options that a scene was loaded with, as parts of its render description.
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>

#include "delegate/description/render_description.h"

namespace alabaster::view {

/// Calls visit(&name) for each name of a file to read in a description or a part of it.
void for_each_input_name(nlohmann::json* value, const std::function<void(nlohmann::json*)>& visit);

/// Writes overrides, the chosen camera, and the models' scene, animation, variant and time into `document`, as the
/// loader takes them after the description. The user's words name files from the working folder: they become absolute.
/// The dome is left out: it is a light of the loaded scene.
void add_load_options(const hd::description::LoadOptions& options, nlohmann::json* document);

}  // namespace alabaster::view
