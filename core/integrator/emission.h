// Light that a path's ray meets, weighed against light sampling by the power heuristic (direct_light.h has the other
// half of the weight).
#pragma once

#include "core/integrator/vertex.h"

namespace alabaster {

/// Adds the light of the lights without geometry on the path's segment, and of infinite ones if the ray `escaped`. A
/// ray that begins where light was sampled meets those with a shadow link, beyond what casts no shadow for them; so
/// does one that begins at a hidden boundary which casts one. Returns it.
Rgb meet_lights(const PathContext& context, bool escaped, Path* path);

/// Of the surface at `v`.
Rgb surface_emission(const Vertex& v, const Path& path);

}  // namespace alabaster
