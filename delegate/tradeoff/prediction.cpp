#include "delegate/tradeoff/prediction.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace alabaster::tradeoff {
namespace {

using Factors = std::array<double, 3>;  // one factor for each unknown: ln E^2 of the last probe, p, outline share

// The prior from other scenes: mean and standard deviation.
constexpr double kExponent = 1.02, kExponentSigma = 0.08;
constexpr double kOutlineShare = 0.10, kOutlineShareSigma = 0.12;
// The model's own error in ln E^2 and in ln cost.
constexpr double kModelSigma = 0.12, kCostSigma = 0.05;
constexpr double kOvershootSigma = 0.08;
// The least error that all estimates of ln E^2 share (kSure in frame_error.cpp).
constexpr double kSureLaw = 0.05;

double square(double x) {
  return x * x;
}

/// Observations y = row . unknowns, each with a standard deviation, summed up as normal equations.
class LeastSquares {
 public:
  void add(const Factors& row, double y, double sigma) {
    for (size_t i = 0; i < 3; ++i) {
      for (size_t j = 0; j < 3; ++j) normal_[i][j] += row[i] * row[j] / square(sigma);
      right_[i] += row[i] * y / square(sigma);
    }
  }

  /// Solves by Gauss-Jordan elimination. Priors and at least one observation make the matrix positive definite, so no
  /// pivoting is needed.
  void solve() {
    std::array<Factors, 3> a = normal_;
    covariance_ = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    for (size_t k = 0; k < 3; ++k) {
      const double pivot = a[k][k];
      for (size_t j = 0; j < 3; ++j) a[k][j] /= pivot, covariance_[k][j] /= pivot;
      for (size_t i = 0; i < 3; ++i) {
        const double factor = i == k ? 0 : a[i][k];
        for (size_t j = 0; j < 3; ++j) {
          a[i][j] -= factor * a[k][j];
          covariance_[i][j] -= factor * covariance_[k][j];
        }
      }
    }
    for (size_t i = 0; i < 3; ++i)
      for (size_t j = 0; j < 3; ++j) unknowns_[i] += covariance_[i][j] * right_[j];
  }

  const Factors& unknowns() const { return unknowns_; }
  double variance(const Factors& gradient) const {
    double sum = 0;
    for (size_t i = 0; i < 3; ++i)
      for (size_t j = 0; j < 3; ++j) sum += gradient[i] * covariance_[i][j] * gradient[j];
    return sum;
  }

 private:
  std::array<Factors, 3> normal_{}, covariance_{};
  Factors right_{}, unknowns_{};
};

bool is_rendered(const Probe& p) {
  return p.pixels > 0 && p.samples > 0;
}

bool is_noisy(const Probe& p) {
  return p.error > 0;
}

// Few bright samples move the errors of groups further away than they will be at the end.
double ending_error(const Probe& p) {
  constexpr double kMost = 1.5;
  return p.error * std::clamp(p.groups, 1.0, kMost);
}

// The standard deviation of ln E^2, from the interval E^2 exp(+-1.96 sigma) (frame_error.cpp). It has three parts: the
// scatter of the frame's own error about its expectation, the scatter of the estimate, which is about as large, and the
// uncertainty of the law of convergence, which all probes of a scene share: at least kSureLaw, and much more where
// stratification dominates. The interval does not separate them, so each is taken as large as it can be.
double variance_of(const Probe& p) {
  return std::min(square(2 * std::log(p.high / p.low) / (2 * 1.96)), 25.0);  // an interval may reach down to zero
}

// The estimate's scatter alone, because the expectation is predicted and not the frame's own error.
double independent_sigma(const Probe& p) {
  return std::max(0.01, std::sqrt(std::max(0.0, variance_of(p) - square(kSureLaw)) / 2));
}

// Further probes do not average it away.
double common_variance(const std::vector<Probe>& probes) {
  double least = 25;
  for (const Probe& p : probes)
    if (is_noisy(p)) least = std::min(least, variance_of(p));
  return least;
}

/// The outlines per pixel of a frame relative to the last probe's, less 1; they are proportional to 1 / sqrt(N).
double coarseness(double pixels, const Probe& last) {
  return std::sqrt(last.pixels / pixels) - 1;
}

Range around(double value, double sigma) {
  return {value, value * std::exp(-1.96 * sigma), value * std::exp(1.96 * sigma)};
}

// The difference of the last two probes in the logarithm of the cost of a sample.
double cost_sigma(const std::vector<Probe>& probes, double Probe::*seconds) {
  if (probes.size() < 2) return 2 * kCostSigma;
  const auto cost = [&](const Probe& p) { return p.*seconds / (p.pixels * p.samples); };
  const double last = cost(probes.back()), before = cost(probes[probes.size() - 2]);
  return last > 0 && before > 0 ? std::hypot(kCostSigma, 0.5 * std::log(before / last)) : 2 * kCostSigma;
}

Range cost_of(const std::vector<Probe>& probes, double Probe::*seconds, const Range& samples, double pixels) {
  const Probe& last = probes.back();
  const double per_sample = last.*seconds / (last.pixels * last.samples);
  const double spread = std::log(samples.high / samples.low) / (2 * 1.96);
  return around(samples.value * pixels * per_sample, std::hypot(spread, cost_sigma(probes, seconds)));
}

// Solves 2 ln target = level - p ln(n / last.samples) + share * coarseness for n.
Range samples_for(const std::vector<Probe>& probes, double pixels, double target) {
  const Probe& last = probes.back();
  LeastSquares fit;
  fit.add({0, 1, 0}, kExponent, kExponentSigma);
  fit.add({0, 0, 1}, kOutlineShare, kOutlineShareSigma);
  for (const Probe& p : probes)
    if (is_noisy(p))
      fit.add({1, -std::log(p.samples / last.samples), coarseness(p.pixels, last)}, 2 * std::log(ending_error(p)),
              independent_sigma(p));
  fit.solve();
  const auto [level, exponent, share] = fit.unknowns();
  const double coarse = coarseness(pixels, last);
  const double growth = (level + share * coarse - 2 * std::log(target)) / exponent;
  const double variance = fit.variance({1 / exponent, -growth / exponent, coarse / exponent});
  const double common = square(kModelSigma) + common_variance(probes);
  const double sigma = std::sqrt(variance + common / square(exponent) + square(kOvershootSigma));
  return around(kOvershoot * last.samples * std::exp(growth), sigma);
}

}  // namespace

Prediction predict(const std::vector<Probe>& all, double pixels, double target, double least_samples) {
  std::vector<Probe> probes;
  std::copy_if(all.begin(), all.end(), std::back_inserter(probes), is_rendered);
  Prediction prediction;
  if (probes.empty()) return prediction;
  prediction.known = true;
  prediction.samples = {least_samples, least_samples, least_samples};
  prediction.noisy = std::any_of(probes.begin(), probes.end(), is_noisy);
  if (prediction.noisy) prediction.samples = samples_for(probes, pixels, target);
  for (double* n : {&prediction.samples.value, &prediction.samples.low, &prediction.samples.high})
    *n = std::max(*n, least_samples);
  prediction.wall = cost_of(probes, &Probe::wall, prediction.samples, pixels);
  prediction.cpu = cost_of(probes, &Probe::cpu, prediction.samples, pixels);
  return prediction;
}

}  // namespace alabaster::tradeoff
