// The subsurface lobe of a path: it enters at a vertex and goes on from where the light leaves the body.
#pragma once

#include "core/integrator/path_state.h"

namespace alabaster {

/// Chiang, Kutz, Burley 2016, section 4: the view-dependent term weighs the entry (already in the path's throughput),
/// the light-dependent term the exit, for light sampling and for the continued path alike. Adds the light that meets
/// the exit, and sends the path on from there. False: the path ends.
bool scatter_below_surface(const PathContext& context, const PixelSampler& sampler, const PathVertex& entry,
                           PathState* path);

}  // namespace alabaster
