#include "testenv/support/anisotropic_half_space.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace alabaster::testing {
namespace {

constexpr size_t kDirections = 48;
using Vector = std::array<double, kDirections>;
using Matrix = std::array<Vector, kDirections>;

struct Quadrature {
  Vector mu, weight;
};

// Gauss-Legendre on [0, 1] by Newton's method on P_n.
Quadrature gauss_legendre() {
  constexpr double n = kDirections;
  Quadrature q{};
  for (size_t i = 0; i < kDirections; ++i) {
    double x = std::cos(std::numbers::pi * (static_cast<double>(i) + 0.75) / (n + 0.5)), slope = 1;
    for (int step = 0; step < 20; ++step) {
      double p = 1, previous = 0;
      for (int k = 1; k <= static_cast<int>(kDirections); ++k) {
        const double next = ((2 * k - 1) * x * p - (k - 1) * previous) / k;
        previous = p;
        p = next;
      }
      slope = n * (x * p - previous) / (x * x - 1);
      x -= p / slope;
    }
    q.mu[i] = (1 + x) / 2;
    q.weight[i] = 1 / ((1 - x * x) * slope * slope);
  }
  return q;
}

Matrix multiply(const Matrix& a, const Matrix& b) {
  Matrix c{};
  for (size_t i = 0; i < kDirections; ++i)
    for (size_t k = 0; k < kDirections; ++k)
      for (size_t j = 0; j < kDirections; ++j) c[i][j] += a[i][k] * b[k][j];
  return c;
}

// alpha/2 p(mu_i, +-mu_j) w_j, averaged over azimuth: sum_l g^l (2l+1) P_l P_l, to the degree that the quadrature
// integrates exactly, so that no energy is lost.
void phase_matrices(const Quadrature& q, double alpha, double g, Matrix* forward, Matrix* backward) {
  Vector p, previous{};
  p.fill(1);
  double moment = 1;
  for (size_t l = 0; l < kDirections; ++l, moment *= g) {
    const double degree = static_cast<double>(l), scale = alpha / 2 * (2 * degree + 1) * moment;
    for (size_t i = 0; i < kDirections; ++i)
      for (size_t j = 0; j < kDirections; ++j) {
        const double term = scale * p[i] * p[j] * q.weight[j];
        (*forward)[i][j] += term;
        (*backward)[i][j] += l % 2 == 0 ? term : -term;
      }
    for (size_t i = 0; i < kDirections; ++i) {
      const double next = ((2 * degree + 1) * q.mu[i] * p[i] - degree * previous[i]) / (degree + 1);
      previous[i] = p[i];
      p[i] = next;
    }
  }
}

}  // namespace

double anisotropic_half_space_albedo(double one_minus_alpha, double g) {
  const Quadrature q = gauss_legendre();
  Matrix forward{}, backward{}, reflection{};
  phase_matrices(q, 1 - one_minus_alpha, g, &forward, &backward);
  for (size_t i = 0; i < kDirections; ++i)
    for (size_t j = 0; j < kDirections; ++j) {
      forward[i][j] /= q.mu[i];
      backward[i][j] /= q.mu[i];
    }
  // R_ij (1/mu_i + 1/mu_j) = (B + F R + R F + R B R)_ij, from R = 0; F and B already over mu.
  double albedo = 0;
  for (int step = 0; step < 100000; ++step) {
    const Matrix ahead = multiply(reflection, forward), through = multiply(forward, reflection);
    const Matrix back = multiply(multiply(reflection, backward), reflection);
    double next = 0;
    for (size_t i = 0; i < kDirections; ++i)
      for (size_t j = 0; j < kDirections; ++j) {
        const double sum = backward[i][j] + through[i][j] + ahead[i][j] + back[i][j];
        reflection[i][j] = sum / (1 / q.mu[i] + 1 / q.mu[j]);
        next += 2 * q.weight[i] * q.mu[i] * reflection[i][j];
      }
    // Each step adds a collision. The rest of the series is at most the last term over sqrt(1 - alpha).
    if (next - albedo < 1e-10 * std::sqrt(one_minus_alpha)) return next;
    albedo = next;
  }
  return albedo;
}

}  // namespace alabaster::testing
