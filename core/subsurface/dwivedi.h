// Guiding towards a plane surface after Dwivedi 1982, "A new importance-biasing scheme for deep-penetration Monte
// Carlo" (in rendering: Krivanek and d'Eon 2014, "A Zero-Variance-Based Sampling Scheme for Monte Carlo Subsurface
// Scattering").
//
// random_walk.md derives the densities. Here they are written in x = 1/nu0, which is 0 without absorption and nears 1
// in the dark; nu0 >= 1 is Case's discrete eigenvalue.
#pragma once

#include <cmath>
#include <iterator>
#include <limits>

namespace alabaster {

/// 1/nu0 and what comes with it.
struct DwivediMode {
  double x = 0;      // 1/nu0 = tanh(theta)
  double theta = 0;  // atanh(x)
  double alpha = 1;  // x/theta: of the medium that x belongs to
};

/// Solves alpha atanh(x) = x for 1 - alpha in [0,1]; relative error of x below 4e-7. Without scattering (1 - alpha = 1)
/// there is no such mode: x = 1.
inline DwivediMode dwivedi_mode(double one_minus_alpha) {
  const double c = one_minus_alpha, alpha = 1 - c;
  // x^2/c through the roots at Chebyshev's nodes; it begins as 3 - 2.4 c.
  constexpr double kFitted = 0.72;
  if (c <= kFitted) {
    constexpr double p[] = {3.0000003159,  -2.4000874301, 0.072501606373, 0.0012159062548, 0.64147870629,
                            -2.6718542636, 7.6992802699,  -12.352235347,  10.897966836,    -3.8769873124};
    double ratio = 0;
    for (size_t i = std::size(p); i-- > 0;) ratio = ratio * c + p[i];
    const double x = std::sqrt(c * ratio), theta = x < 1e-3 ? x * (1 + x * x / 3) : 0.5 * std::log((1 + x) / (1 - x));
    return {x, theta, theta > 0 ? x / theta : 1};
  }
  if (!(alpha > 0)) return {1, std::numeric_limits<double>::infinity(), 0};
  // Newton's method in theta = atanh(x), alpha theta = tanh(theta), where the root stays simple as x nears 1.
  double theta = 1 / alpha;
  for (int i = 0; i < 4; ++i) {
    const double tangent = std::tanh(theta);
    theta -= (tangent - alpha * theta) / (1 - tangent * tangent - alpha);
  }
  const double x = std::tanh(theta);
  return {x, theta, x / theta};
}

/// The inverse distribution function of p(mu) = x/(2 theta (1 - x mu)) on [-1,1], u in [0,1]; x > 0 and not tiny
/// (cancellation: absolute error 1e-16/x).
inline double sample_dwivedi(double u, const DwivediMode& mode) {
  const double mu = (1 - (1 + mode.x) * std::exp(-2 * mode.theta * u)) / mode.x;
  return std::fmin(std::fmax(mu, -1.0), 1.0);
}

/// x/sinh(x), x >= 0: 1 at 0, 0 where sinh overflows.
inline double x_over_sinh(double x) {
  return x > 1e-4 ? x / std::sinh(x) : 1 - x * x / 6;
}

/// Inverse distribution function of the density proportional to exp(x mu) on [-1,1], x >= 0.
inline double sample_exponential_cosine(double u, double x) {
  const double mu = x > 1e-4 ? 1 + std::log(u + (1 - u) * std::exp(-2 * x)) / x : 2 * u - 1 + 2 * x * u * (1 - u);
  return std::fmin(std::fmax(mu, -1.0), 1.0);
}
/// The same density over the uniform one, 1/2: exp(x mu) x/sinh(x).
inline double exponential_cosine_factor(double mu, double x) {
  return x > 1e-4 ? 2 * x * std::exp(x * (mu - 1)) / -std::expm1(-2 * x) : std::exp(x * mu);
}

}  // namespace alabaster
