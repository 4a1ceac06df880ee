#pragma once

#include "core/sampling/pixel_sampler.h"

namespace alabaster::test {

/// In the unit cube.
inline Vec3f random_point(Rng& rng) {
  const float x = rng.uniform(), y = rng.uniform();
  return {x, y, rng.uniform()};
}

}  // namespace alabaster::test
