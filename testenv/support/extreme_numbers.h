// Random parameters for fuzz tests, at the ends of their range as often as between.
#pragma once

#include <array>

#include "core/color/rgb.h"
#include "core/sampling/pixel_sampler.h"

namespace alabaster::testing {

/// The values of [0,1] at which formulas fail first.
inline constexpr std::array<float, 8> kExtremes = {0, 1e-6f, 1e-3f, 0.02f, 0.5f, 0.98f, 1 - 1e-6f, 1};

/// In [0,1]: an extreme as often as anything between.
inline float unit_or_extreme(Rng& rng) {
  const uint32_t pick = rng.next() % (2 * kExtremes.size());
  return pick < kExtremes.size() ? kExtremes[pick] : rng.uniform();
}

inline Rgb color_or_extreme(Rng& rng) {
  const float r = unit_or_extreme(rng), g = unit_or_extreme(rng);
  return {r, g, unit_or_extreme(rng)};
}

}  // namespace alabaster::testing
