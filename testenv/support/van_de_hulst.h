// Van de Hulst's inversion (1980), to compare the renderer's with: A = (1-s)(1-.139 s)/(1+1.17 s) for a half-space,
// s = sqrt((1-alpha)/(1-alpha g)). It takes g by similarity alone.
#pragma once

#include <algorithm>
#include <cmath>

namespace alabaster::testing {

/// 1 - alpha for A in [0, 1]: the root in [0, 1] of 0.139 s^2 - (1.139 + 1.17 A) s + (1 - A) = 0.
inline double van_de_hulst_complement(double albedo, double g = 0) {
  const double b = 1.139 + 1.17 * albedo;
  const double s = 2 * (1 - albedo) / (b + std::sqrt(b * b - 4 * 0.139 * (1 - albedo)));
  const double alike = std::min(s * s, 1.0);
  return alike * (1 - g) / (1 - g * alike);
}

}  // namespace alabaster::testing
