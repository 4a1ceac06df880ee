#include "core/subsurface/lambert_limit.h"

#include <algorithm>
#include <cmath>

namespace alabaster {
namespace {

/// Mean distance between entry and exit on a slab, in mean free paths: 2 to 9 % above what walks of A = 0.2 .. 0.95
/// measure (.845, 1.378, 2.390, 4.016). Infinite without absorption.
double mean_exit_radius(double one_minus_alpha) {
  const double x = -0.5 * std::log(one_minus_alpha);
  return 0.5 + x * (0.75 + 0.055 * x);
}

/// In mean free paths. The extrapolated boundary is left out: it makes up for what diffusion theory does not see, light
/// that crosses after few collisions where absorption is strong.
double opaque_depth(double one_minus_alpha) {
  constexpr double kPeak = 4 / (3 * kLambertTolerance);
  // Diffusion's attenuation exceeds the true one, at most 1, where absorption is strong.
  const double kappa = std::min(std::sqrt(3 * one_minus_alpha), 1.0);
  return kappa > 1e-4 ? std::asinh(kPeak * kappa) / kappa : kPeak;
}

}  // namespace

LambertLimit lambert_limit(const Medium& medium) {
  double reach = 0, depth = 0;
  for (int c = 0; c < 3; ++c) {
    if (!medium.active[c]) continue;
    const double mfp = 1 / double(medium.sigma_t[c]), complement = medium.one_minus_alpha[c];
    reach = std::max(reach, mfp * mean_exit_radius(complement));
    depth = std::max(depth, mfp * opaque_depth(complement));
  }
  return {static_cast<float>(reach), static_cast<float>(depth)};
}

float lambert_probability(float width, const LambertLimit& limit) {
  // The blur of p reach/(pi w) stays below the tolerance all the way; it is largest at 0.7 kFull.
  constexpr double kFull = 1.2 / (3.14159265358979323846 * kLambertTolerance);
  const double ratio = double(width) / limit.reach;
  if (!(ratio > 0.25 * kFull)) return 0;
  const double x = std::min(1 + 0.5 * std::log2(ratio / kFull), 1.0);
  return static_cast<float>(x * x * (3 - 2 * x));
}

}  // namespace alabaster
