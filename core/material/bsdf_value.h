// The answers for a pair of directions. A lobe has f alone, which is reciprocal; a BSDF has the cosine in it, because
// its lobes may count light by the cosines to different normals.
#pragma once

#include "core/color/rgb.h"

namespace alabaster {

/// Both from one evaluation, because they share the facet and its density.
struct LobeValue {
  Rgb f{0.0f};
  float pdf = 0;  // of sampling wi given wo, per solid angle
};

struct BsdfValue {
  Rgb f_cos{0.0f};
  float pdf = 0;
};

}  // namespace alabaster
