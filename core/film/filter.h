// The pixel filter, importance-sampled: the film position of a sample is drawn from the filter around the pixel's
// centre, so every sample has weight one (Ernst et al. 2006, "Filter Importance Sampling").
#pragma once

#include "core/math/vector.h"

namespace alabaster {

enum class PixelFilter { box, triangle, gaussian, blackman_harris };

/// Offset from the pixel's centre, in pixels, for u in [0,1)^2. Widths of support: box 1, triangle 2, gaussian 3
/// (sigma 0.5), blackman_harris 3.
Vec2f sample_pixel_filter(PixelFilter filter, const Vec2f& u);

}  // namespace alabaster
