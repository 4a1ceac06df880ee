// The pixel filter, importance-sampled: a sample's film position is drawn from the filter about its pixel's centre, so
// every sample has weight one (Ernst et al. 2006, "Filter Importance Sampling").
#pragma once

#include "core/math/vector.h"

namespace alabaster {

enum class PixelFilter { box, triangle, gaussian, blackman_harris };

/// Offset from the pixel centre in pixels. Supports: box 1 wide, triangle 2, gaussian 3 (sigma .5),
/// blackman_harris 3.
Vec2f sample_pixel_filter(PixelFilter filter, const Vec2f& u);

}  // namespace alabaster
