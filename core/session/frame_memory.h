// The memory that a RenderSession takes for a frame.
#pragma once

#include <cstddef>

#include "core/convergence/sample_allocation.h"
#include "core/film/film.h"
#include "core/session/render_settings.h"

namespace alabaster {

inline bool is_adaptive(const RenderSettings& settings) {
  return settings.adaptive && settings.samples >= 2 * kPilotSamples;
}

/// The planes besides AOVs of the film that a render with these settings fills. `light_groups`: that AOVs show.
FilmExtras film_extras(const RenderSettings& settings, size_t light_groups = 0);

/// Bytes that a render takes at most: its film, a second film where an error ends it (GroupStopping), the rates of an
/// adaptive frame, and what the decisions and the estimate of the error take for a moment. Not counted: some hundred
/// bytes per tile, and the denoiser (denoise_bytes()). `aovs`: with_guides() of those of the request.
size_t frame_bytes(const PixelRect& window, AovSet aovs, const RenderSettings& settings, size_t light_groups = 0);

}  // namespace alabaster
