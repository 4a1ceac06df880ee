// Tests that a sampler follows its pdf. Pearson's chi-square test of binned samples against the pdf integrated over
// each bin, on the sphere and on the unit square.
//
//   const auto result = chi_square_sphere([&](Rng& rng) { return light.sample(uniform2(rng)); },
//                                         [&](const Vec3f& w) { return light.pdf(w); });
//   EXPECT_TRUE(plausible(result)) << name;
//
// A sampler may return nothing (an absorbed sample); the pdf then integrates to less than one and the missing share is
// a bin of its own. Bins of low expectation are pooled. A sample where the pdf is zero over its whole bin, a non-finite
// or negative pdf, and a pdf that integrates to more than one have p = 0. Directional distributions narrower than a
// bin are tested well only if the bins are fine near them: `frame` puts the pole (bins there are small caps) where they
// peak.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "core/math/frame.h"
#include "core/math/vector.h"
#include "core/sampling/pixel_sampler.h"
#include "testenv/support/statistics.h"

namespace alabaster::testing {

inline Vec2f uniform2(Rng& rng) {
  const float x = rng.uniform();
  return {x, rng.uniform()};
}

struct ChiSquareOptions {
  int bins_x = 40;           // azimuth on the sphere, x on the square
  int bins_y = 40;           // cos(theta) over [-1, 1] on the sphere, y on the square
  int samples = 200000;      // independent; run_samples() of them
  uint64_t seed = 1;         // fixed: a test passes always or never; run_seed() of it
  double min_expected = 5;   // bins expecting fewer samples are pooled
  Frame frame{};             // sphere only: bins are laid about frame.n, azimuth from frame.s
  double pole_exponent = 1;  // sphere only: > 1 makes the bins finer towards +frame.n: 1 - cos ~ (row)^exponent
};

struct ChiSquareResult {
  double p_value = 0;  // of this test alone
  double statistic = 0;
  int degrees_of_freedom = 0;
  double pdf_integral = 0;
  std::string report;  // the numbers, and for a small p the reason and the worst bins as a table
};

using SphereSampler = std::function<std::optional<Vec3f>(Rng&)>;
using SpherePdf = std::function<float(const Vec3f&)>;  // per solid angle
using SquareSampler = std::function<std::optional<Vec2f>(Rng&)>;
using SquarePdf = std::function<float(const Vec2f&)>;  // per unit area of [0,1)^2

/// Samples must be unit.
ChiSquareResult chi_square_sphere(const SphereSampler& sample, const SpherePdf& pdf,
                                  const ChiSquareOptions& options = {});
/// Samples must lie in [0,1)^2; one outside fails the test.
ChiSquareResult chi_square_square(const SquareSampler& sample, const SquarePdf& pdf,
                                  const ChiSquareOptions& options = {});

/// Integral over the sphere of `f` per solid angle; frame and pole_exponent as in ChiSquareOptions. Absolute error
/// about 1e-5 for a bounded f with kinks and jumps.
double integrate_sphere(const std::function<double(const Vec3f&)>& f, const Frame& frame = {},
                        double pole_exponent = 1);

/// Upper regularized incomplete gamma function Q(a, x), a > 0, x >= 0.
double gamma_q(double a, double x);

/// Integral of `f` over [x0,x1] x [y0,y1]: Gauss-Legendre on a quadtree refined to an absolute error of about
/// `tolerance`, but never finer than 1/512 of the rectangle: a jump across it leaves an error of about a thousandth of
/// what it cuts off. For integrands with kinks and jumps, not for poles.
double integrate_rectangle(const std::function<double(double, double)>& f, const double (&x)[2], const double (&y)[2],
                           double tolerance);

}  // namespace alabaster::testing
