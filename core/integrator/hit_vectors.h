// The vectors of the first hit that AOVs show: its place and normal seen from the camera, its place in the world, its
// texture coordinates, its motion, its primvars.
#pragma once

#include "core/integrator/vertex.h"

namespace alabaster {

/// Fills context.vectors, which must not be null, as far as AOVs show them.
void record_hit_vectors(const PathContext& context, const Vertex& v, FilmSample* out);

}  // namespace alabaster
