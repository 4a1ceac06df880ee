// The densities that a walk's directions are drawn from: chi-square tests hold the samplers against them.
#pragma once

#include "core/math/vector.h"
#include "core/subsurface/dwivedi.h"

namespace alabaster::testing {

inline float pdf_henyey_greenstein(float cosine, float g) {
  // 1 + g^2 - 2 g cos without cancellation where it is small.
  const float along = g < 0 ? -cosine : cosine, size = std::abs(g);
  const float squared = sqr(1 - size) + 2 * size * (1 - along);
  return (1 - g * g) * 0.25f * kInvPi / (squared * std::sqrt(squared));
}

/// Density of mu on [-1,1]: p(mu) = x/(2 theta (1 - x mu)); 1/2 for x = 0.
inline double pdf_dwivedi(double mu, const DwivediMode& mode) {
  return 0.5 * mode.alpha / (1 - mode.x * mu);
}

}  // namespace alabaster::testing
