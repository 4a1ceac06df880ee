// Burley's normalized diffusion profile in closed form, for comparison with the carrier.
#pragma once

#include <cmath>

namespace alabaster::testing {

/// Share of the light that leaves within r on a plane.
inline double diffusion_profile_cdf(double r, double d) {
  return -0.25 * std::expm1(-r / d) - 0.75 * std::expm1(-r / (3 * d));
}

}  // namespace alabaster::testing
