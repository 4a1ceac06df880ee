// The AOVs of the surfaces that a camera's ray meets first.
#pragma once

#include "core/integrator/path_state.h"

namespace alabaster {

/// Sets the values of the first surface for the requested AOVs. `distance`: from the origin of the camera's ray to `v`.
void record_first_hit(const PathContext& context, const PathVertex& v, float distance, FilmSample* out);

/// The guides of a denoiser show what a mirror shows: they are those of the first surface that is none, tinted by the
/// mirrors before it, or of the last mirror if the path meets nothing else. They go to `path.guides`.
void record_guides(const PathContext& context, const PathVertex& v, const PathState& path);

/// Shows an image of its surroundings: at most a few pixels wide blurred. Rougher lobes are surfaces to a denoiser.
bool is_mirror(const PathVertex& v, Lobe lobe);

}  // namespace alabaster
