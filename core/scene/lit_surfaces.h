// Finds where light falls on the surfaces of subsurface bodies.
#pragma once

#include "core/scene/scene.h"

namespace alabaster {

/// Gives each body of the snapshot, which has its lights, the direct light on its surface, unless that is even
/// (core/subsurface/lit_surface.h) or the scene has so many bodies that the shadow rays would take long. `alike`: a
/// snapshot whose lights and instances are the same, or null; bodies with the same members have the same light. Throws
/// BuildCancelled.
void find_lit_surfaces(const SceneSnapshot* alike, SceneSnapshot* snapshot, const CancelToken& cancel);

}  // namespace alabaster
