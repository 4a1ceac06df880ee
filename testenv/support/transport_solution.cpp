#include "testenv/support/transport_solution.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace alabaster::testing {
namespace {

/// Exponential integral of order 3, by the recurrence from E1(x) = -Ei(-x).
double e3(double x) {
  if (x <= 0) return 0.5;
  const double e1 = -std::expint(-x), e2 = std::exp(-x) - x * e1;
  return 0.5 * (std::exp(-x) - x * e2);
}

/// Double integral of E1(|x - x'|) over two cells of width h whose centres are `cells` apart.
double cell_coupling(int cells, double h) {
  if (cells == 0) return 2 * (h - 0.5 + e3(h));
  return e3((cells - 1) * h) - 2 * e3(cells * h) + e3((cells + 1) * h);
}

/// Solves (1 - K) x = b by elimination; 1 - K is diagonally dominant. `k` is row-major and is used up.
std::vector<double> solve(std::vector<double> k, std::vector<double> b) {
  const size_t n = b.size();
  for (size_t i = 0; i < n * n; ++i) k[i] = (i % (n + 1) == 0 ? 1.0 : 0.0) - k[i];
  for (size_t i = 0; i < n; ++i)
    for (size_t row = i + 1; row < n; ++row) {
      const double factor = k[row * n + i] / k[i * n + i];
      for (size_t column = i; column < n; ++column) k[row * n + column] -= factor * k[i * n + column];
      b[row] -= factor * b[i];
    }
  for (size_t i = n; i-- > 0;) {
    for (size_t column = i + 1; column < n; ++column) b[i] -= k[i * n + column] * b[column];
    b[i] /= k[i * n + i];
  }
  return b;
}

SlabAnswer solve_slab_on(int cells, double thickness, double one_minus_alpha) {
  const auto n = static_cast<size_t>(cells);
  const double h = thickness / cells, alpha = 1 - one_minus_alpha;
  std::vector<double> coupling(n), kernel(n * n), source(n), to_front(n);
  for (int i = 0; i < cells; ++i) {
    coupling[static_cast<size_t>(i)] = 0.5 * alpha * cell_coupling(i, h) / h;
    to_front[static_cast<size_t>(i)] = e3(i * h) - e3((i + 1) * h);  // Int of E2 over the cell
    source[static_cast<size_t>(i)] = 2 * to_front[static_cast<size_t>(i)] / h;
  }
  for (size_t i = 0; i < n; ++i)
    for (size_t j = 0; j < n; ++j) kernel[i * n + j] = coupling[i > j ? i - j : j - i];
  const std::vector<double> density = solve(std::move(kernel), source);
  SlabAnswer answer{0, slab_zero_scatter(thickness), 0};
  for (size_t i = 0; i < n; ++i) {
    answer.reflectance += 0.5 * alpha * density[i] * to_front[i];
    answer.transmittance += 0.5 * alpha * density[i] * to_front[n - 1 - i];
  }
  return answer;
}

/// r times the mean radiance obeys a slab's equation, continued oddly through the centre (Case, de Hoffmann and Placzek
/// 1953).
double solve_sphere_on(int cells, double radius, double one_minus_alpha) {
  const auto n = static_cast<size_t>(cells);
  const double h = radius / cells, alpha = 1 - one_minus_alpha;
  std::vector<double> kernel(n * n), source(n);
  const auto centre = [&](size_t i) { return (static_cast<double>(i) + 0.5) * h; };
  std::vector<double> coupling(2 * n);
  for (int i = 0; i < 2 * cells; ++i) coupling[static_cast<size_t>(i)] = 0.5 * cell_coupling(i, h) / h;
  for (size_t i = 0; i < n; ++i) {
    source[i] = centre(i);
    for (size_t j = 0; j < n; ++j) {
      const double k = coupling[i > j ? i - j : j - i] - coupling[i + j + 1];
      source[i] -= k * centre(j);  // radiance at r from uniform surroundings, without scatterers
      kernel[i * n + j] = alpha * k;
    }
  }
  const std::vector<double> u = solve(std::move(kernel), source);
  double integral = 0;
  for (size_t i = 0; i < n; ++i) integral += u[i] * centre(i) * h;
  return 1 - 4 * one_minus_alpha * integral / (radius * radius);
}

/// Second order in h: each pair of grids gives a limit, and two limits the error.
class Limit {
 public:
  static constexpr int kCells[3] = {75, 150, 300};

  void add(double on_grid) {
    previous_limit_ = limit_;
    limit_ = on_grid + (on_grid - on_grid_) / 3;
    on_grid_ = on_grid;
  }
  double value() const { return limit_; }
  double error() const { return std::abs(limit_ - previous_limit_); }

 private:
  double on_grid_ = 0, limit_ = 0, previous_limit_ = 0;
};

}  // namespace

double slab_zero_scatter(double thickness) {
  return 2 * e3(thickness);
}

double sphere_zero_scatter(double radius) {
  return (-std::expm1(-2 * radius) - 2 * radius * std::exp(-2 * radius)) / (2 * radius * radius);
}

SlabAnswer solve_slab(double thickness, double one_minus_alpha) {
  Limit reflectance, transmittance;
  for (const int cells : Limit::kCells) {
    const SlabAnswer answer = solve_slab_on(cells, thickness, one_minus_alpha);
    reflectance.add(answer.reflectance);
    transmittance.add(answer.transmittance);
  }
  return {reflectance.value(), transmittance.value(), std::max(reflectance.error(), transmittance.error())};
}

SphereAnswer solve_sphere(double radius, double one_minus_alpha) {
  Limit albedo;
  for (const int cells : Limit::kCells) albedo.add(solve_sphere_on(cells, radius, one_minus_alpha));
  return {albedo.value(), albedo.error()};
}

}  // namespace alabaster::testing
