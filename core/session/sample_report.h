// A pixel's samples as text: for those who ask why it has its colour.
#pragma once

#include <optional>
#include <string>

#include "core/session/tile_renderer.h"

namespace alabaster {

/// The path of one sample, vertex by vertex, traced with the very numbers that the render takes. Without a sample: the
/// colour of each sample that an even frame takes in the pixel, and the path of the first that fails a check, else of
/// the first that is not finite, else of the brightest.
std::string report_sample(const RenderRequest& request, int x, int y, std::optional<uint32_t> sample);

}  // namespace alabaster
