// Which objects have room for the shortcuts of subsurface walks, and the distance grids that sphere steps need.
#pragma once

#include "core/scene/scene.h"

namespace alabaster {

/// Gives the walks of instances a distance grid where they are long enough, and the object wide enough, for sphere
/// steps to pay by what the materials say, and says where guiding pays; builds the grids that are missing (2 MB at most
/// per prototype) and counts their memory. Bodies of several shells have none. Call once, when instances, materials and
/// walk sets stand.
void add_distance_grids(SceneSnapshot* snapshot);

/// The least factor by which a linear map stretches a vector: its smallest singular value, rounded down.
float least_stretch(const Affine& map);

}  // namespace alabaster
