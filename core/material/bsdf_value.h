// The answer of a lobe, or of a whole BSDF, for a pair of directions.
#pragma once

#include "core/color/rgb.h"

namespace alabaster {

/// Both from one evaluation, because they share the facet and its density.
struct BsdfValue {
  Rgb f{0.0f};    // without the cosine
  float pdf = 0;  // of sampling wi given wo, per solid angle
};

}  // namespace alabaster
