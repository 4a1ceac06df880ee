#include "testenv/support/half_space.h"

#include <algorithm>
#include <cmath>

namespace alabaster::testing {
namespace {

constexpr double kHalfPi = 1.57079632679489661923;

/// Integral over [0, length] by the tanh-sinh rule (Takahasi and Mori 1974). The integrand gets the distances from both
/// ends, each with full relative precision, so that what is singular at an end may be evaluated there.
template <class Integrand>
double integrate_tanh_sinh(double length, const Integrand& integrand) {
  constexpr double kStep = 1.0 / 16;
  constexpr int kSteps = 72;  // up to 4.5: the weights there are below 1e-60
  double sum = 0;
  for (int i = -kSteps; i <= kSteps; ++i) {
    const double x = kStep * i;
    const double q = std::exp(-2 * kHalfPi * std::sinh(std::abs(x)));
    const double near = length * q / (1 + q), far = length / (1 + q);
    const double weight = 2 * kHalfPi * std::cosh(x) * q / ((1 + q) * (1 + q));
    if (near > 0) sum += weight * (x < 0 ? integrand(near, far) : integrand(far, near));
  }
  return kStep * length * sum;
}

/// 1 - t cot t without cancellation.
double one_minus_t_cot_t(double t) {
  if (t > 0.25) return 1 - t / std::tan(t);
  const double t2 = t * t;
  return t2 * (1.0 / 3 +
               t2 * (1.0 / 45 + t2 * (2.0 / 945 + t2 * (1.0 / 4725 + t2 * (2.0 / 93555 + t2 * (1382.0 / 638512875))))));
}

}  // namespace

double chandrasekhar_h(double mu, double one_minus_alpha) {
  if (!(mu > 0)) return 1;
  const double alpha = 1 - one_minus_alpha;
  const auto integrand = [&](double t, double from_right_angle) {
    const double sine = t < from_right_angle ? std::sin(t) : std::cos(from_right_angle);
    const double cosine = t < from_right_angle ? std::cos(t) : std::sin(from_right_angle);
    const double logarithm = std::log(one_minus_alpha + alpha * one_minus_t_cot_t(t));
    return logarithm / (cosine * cosine + mu * mu * sine * sine);
  };
  return std::exp(-mu / (2 * kHalfPi) * integrate_tanh_sinh(kHalfPi, integrand));
}

double half_space_albedo(double one_minus_alpha) {
  const double complement = std::min(std::max(one_minus_alpha, 0.0), 1.0);
  const double first_moment =
      integrate_tanh_sinh(1.0, [&](double mu, double) { return mu * chandrasekhar_h(mu, complement); });
  return 1 - 2 * std::sqrt(complement) * first_moment;
}

}  // namespace alabaster::testing
