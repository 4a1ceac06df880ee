// The options of render that say how its scene is loaded, and what a render tells at its end.
#pragma once

#include <string>

#include "delegate/cli/commands.h"
#include "delegate/description/render_description.h"

namespace alabaster::cli {

/// When frame `frame` is shown, by --fps.
double seconds_at(const RenderArguments& a, uint32_t frame);

/// The first frame's, where there are --frames.
hd::description::LoadOptions load_options(const RenderArguments& a);

/// "noise: 2.00 % relative RMSE ..." of a render's statistics; empty if the noise is not known.
std::string noise_text(const hd::Dictionary& stats);

}  // namespace alabaster::cli
