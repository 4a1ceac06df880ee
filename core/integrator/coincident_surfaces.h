// Surfaces of several bodies that lie on one another. Internal to this room.
#pragma once

#include "core/integrator/vertex.h"
#include "core/sampling/pixel_sampler.h"

namespace alabaster {

/// Finds the surfaces of other bodies between the two origins of rays that leave this interface: the next ray would
/// miss them. Sets v->beyond if clear ones do, and v->air_beyond if holes do. The path's media and air, on the near
/// side, then agree with them, whichever of the faces its ray found first. True: v->triangle is now on one that takes
/// this one's place.
bool find_coincident_surfaces(const PathContext& context, const PixelSampler& sampler, bool inside, Vertex* v,
                              Path* path);

}  // namespace alabaster
