// The AOVs of the surfaces that a camera's ray meets first.
#pragma once

#include "core/integrator/vertex.h"

namespace alabaster {

/// Sets the values of the first surface for the requested AOVs. `distance`: from the origin of the camera's ray to `v`.
void record_first_hit(const PathContext& context, const Vertex& v, const Path& path, const PixelSampler& sampler,
                      float distance, FilmSample* out);

/// A denoiser's features show what a mirror shows: they are those of the first surface that is none, tinted by the
/// mirrors before it, or of the last mirror if the path meets nothing else. They go to `path.features`.
void record_features(const PathContext& context, const Vertex& v, const Path& path);

/// Shows an image of its surroundings: at most a few pixels wide blurred. Rougher lobes are surfaces to a denoiser.
bool is_mirror(const Vertex& v, Lobe lobe);

}  // namespace alabaster
