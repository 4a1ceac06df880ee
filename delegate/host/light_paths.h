// Light path expressions, as RenderVars of other renderers write them, by the AOVs that show what they select.
#pragma once

#include <string>
#include <vector>

#include "delegate/api/scene_types.h"

namespace alabaster::hd::host {

/// The AOV of "lpe:EXPRESSION"; the name itself of any other, and of an expression that no AOV shows.
std::string aov_of_light_paths(const std::string& name);
/// The same of all variables. Layers that nobody named get the names of their AOVs.
void resolve_light_paths(std::vector<RenderVar>* vars);
/// What to say of "lpe:EXPRESSION" that no AOV shows; empty: it is none.
std::string light_paths_fault(const std::string& name);

}  // namespace alabaster::hd::host
