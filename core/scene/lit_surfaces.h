// Where light falls on the surfaces of subsurface bodies.
#pragma once

#include "core/scene/scene.h"

namespace alabaster {

/// Gives each body of the snapshot, which has its lights, a way to find the direct light on its surface once a walk
/// asks, unless the scene has so many bodies that the shadow rays would take long. The snapshot must stay where it is
/// in memory. `alike`: a snapshot whose lights and instances are the same, or null; bodies with the same members share
/// the light that it has found.
void plan_lit_surfaces(const SceneSnapshot* alike, SceneSnapshot* snapshot);

}  // namespace alabaster
