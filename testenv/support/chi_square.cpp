#include "testenv/support/chi_square.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <limits>
#include <numeric>
#include <sstream>
#include <vector>

namespace alabaster::testing {
namespace {

using Plane = std::function<double(double, double)>;

// Five-point Gauss-Legendre rule on [0, 1] (Abramowitz and Stegun, table 25.4, mapped from [-1, 1]).
constexpr double kNode[5] = {0.04691007703066800, 0.23076534494715845, 0.5, 0.76923465505284155, 0.95308992296933200};
constexpr double kWeight[5] = {0.11846344252809454, 0.23931433524968324, 0.28444444444444444, 0.23931433524968324,
                               0.11846344252809454};

struct Rectangle {
  double x0, x1, y0, y1;
};

double gauss(const Plane& f, const Rectangle& r) {
  const double dx = r.x1 - r.x0, dy = r.y1 - r.y0;
  double sum = 0;
  for (int j = 0; j < 5; ++j) {
    for (int i = 0; i < 5; ++i) sum += kWeight[i] * kWeight[j] * f(r.x0 + dx * kNode[i], r.y0 + dy * kNode[j]);
  }
  return sum * dx * dy;
}

struct Refinement {
  double tolerance;
  int min_depth;
};

double refine(const Plane& f, const Rectangle& r, double coarse, const Refinement& until, int depth) {
  const double mx = 0.5 * (r.x0 + r.x1), my = 0.5 * (r.y0 + r.y1);
  const Rectangle part[4] = {{r.x0, mx, r.y0, my}, {mx, r.x1, r.y0, my}, {r.x0, mx, my, r.y1}, {mx, r.x1, my, r.y1}};
  double fine[4], sum = 0;
  for (int i = 0; i < 4; ++i) sum += fine[i] = gauss(f, part[i]);
  constexpr int kMaxDepth = 8;
  // Half the tolerance for each level, not a quarter: along the line of a jump the number of bad cells doubles.
  const bool accurate = !(std::abs(sum - coarse) > std::ldexp(until.tolerance, -depth));
  if ((accurate && depth >= until.min_depth) || depth >= kMaxDepth) return sum;
  double total = 0;
  for (int i = 0; i < 4; ++i) total += refine(f, part[i], fine[i], until, depth + 1);
  return total;
}

const double kTwoPiExact = 2 * std::acos(-1.0);

/// The sphere laid out on the unit square: x = azimuth / 2 pi about frame.n, y = ((1 - cos) / 2)^(1/k), so that
/// d(omega) = 4 pi k y^(k-1) dx dy.
struct SphereMap {
  Frame frame;
  double k;

  Vec3f direction(double x, double y) const {
    const double one_minus_cos = 2 * std::pow(y, k), phi = kTwoPiExact * x;
    const double r = std::sqrt(std::max(0.0, one_minus_cos * (2 - one_minus_cos)));
    return frame.to_world({static_cast<float>(r * std::cos(phi)), static_cast<float>(r * std::sin(phi)),
                           static_cast<float>(1 - one_minus_cos)});
  }
  double solid_angle_per_area(double y) const { return 2 * kTwoPiExact * k * std::pow(y, k - 1); }

  /// Outside the square if `world` is not unit.
  Vec2f locate(const Vec3f& world) const {
    const Vec3f w = frame.to_local(world);
    const double sin2 = static_cast<double>(w.x) * w.x + static_cast<double>(w.y) * w.y;
    const bool unit = std::abs(sin2 + static_cast<double>(w.z) * w.z - 1) < 1e-3;
    if (!unit) return {-1, -1};
    const double azimuth = std::atan2(static_cast<double>(w.y), static_cast<double>(w.x)) / kTwoPiExact;
    // From the sine near the pole, where 1 - cos cancels; from the cosine elsewhere, where the sine does.
    const double one_minus_cos = w.z > 0.5f ? sin2 / (1 + std::sqrt(std::max(0.0, 1 - sin2))) : 1.0 - w.z;
    const double y = std::pow(std::clamp(0.5 * one_minus_cos, 0.0, 1.0), 1 / k);
    return {static_cast<float>(azimuth < 0 ? azimuth + 1 : azimuth), static_cast<float>(y)};
  }
};

struct Bins {
  int nx, ny;
  std::vector<double> observed, expected;
  double missing_observed = 0;

  size_t size() const { return observed.size(); }
};

struct Cell {
  double observed = 0, expected = 0;
};

/// The test's cells: bins of enough expectation as they are, the rest together.
std::vector<Cell> pool(const Bins& bins, double missing_expected, double min_expected) {
  std::vector<Cell> cells;
  Cell rest;
  const auto take = [&](double observed, double expected) {
    if (expected >= min_expected) {
      cells.push_back({observed, expected});
    } else {
      rest.observed += observed;
      rest.expected += expected;
    }
  };
  for (size_t i = 0; i < bins.size(); ++i) take(bins.observed[i], bins.expected[i]);
  take(bins.missing_observed, missing_expected);
  if (rest.expected >= min_expected || cells.empty()) {
    cells.push_back(rest);
  } else {
    // Too small even together: into the smallest of the others.
    const auto smallest = std::min_element(cells.begin(), cells.end(),
                                           [](const Cell& a, const Cell& b) { return a.expected < b.expected; });
    smallest->observed += rest.observed;
    smallest->expected += rest.expected;
  }
  return cells;
}

std::string worst_bins(const Bins& bins) {
  std::vector<size_t> order(bins.size());
  std::iota(order.begin(), order.end(), size_t(0));
  const auto deviation = [&](size_t i) {
    return std::abs(bins.observed[i] - bins.expected[i]) / std::sqrt(std::max(bins.expected[i], 1.0));
  };
  const size_t shown = std::min<size_t>(8, order.size());
  std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(shown), order.end(),
                    [&](size_t a, size_t b) { return deviation(a) > deviation(b); });
  std::ostringstream text;
  text << "\n  bin x    y    observed    expected   deviation (sigma)\n" << std::fixed << std::setprecision(2);
  for (size_t k = 0; k < shown; ++k) {
    const size_t i = order[k], nx = static_cast<size_t>(bins.nx);
    text << "  " << std::setw(5) << i % nx << std::setw(5) << i / nx << std::setw(12) << bins.observed[i]
         << std::setw(12) << bins.expected[i] << std::setw(12) << deviation(i) << "\n";
  }
  return text.str();
}

/// The reason why the samples cannot come from this pdf, whatever the statistic; empty if they can.
std::string plain_contradiction(const Bins& bins, double integral, int samples) {
  std::ostringstream text;
  if (!std::isfinite(integral)) return "the pdf is not finite or is negative somewhere";
  // The integral is good to about 1e-6 per bin at worst; 1e-3 is far beyond that.
  if (integral > 1 + 1e-3) text << "the pdf integrates to " << integral << " > 1; ";
  double impossible = 0;
  for (size_t i = 0; i < bins.size(); ++i) {
    if (bins.expected[i] <= 0) impossible += bins.observed[i];
  }
  // Rounding may carry a stray sample over the edge of the support.
  if (impossible > 1e-5 * samples) text << impossible << " samples in bins where the pdf is zero; ";
  return text.str();
}

ChiSquareResult judge(const Bins& bins, const ChiSquareOptions& options) {
  ChiSquareResult result;
  const double expected_total = std::accumulate(bins.expected.begin(), bins.expected.end(), 0.0);
  result.pdf_integral = expected_total / options.samples;
  std::string reason = plain_contradiction(bins, result.pdf_integral, options.samples);
  const std::vector<Cell> cells = pool(bins, std::max(0.0, options.samples - expected_total), options.min_expected);
  result.degrees_of_freedom = static_cast<int>(cells.size()) - 1;
  for (const Cell& cell : cells) {
    if (cell.expected > 0)
      result.statistic += (cell.observed - cell.expected) * (cell.observed - cell.expected) / cell.expected;
  }
  if (result.degrees_of_freedom < 1) {
    reason += "fewer than two bins expect enough samples: nothing is tested; ";
  } else if (std::isfinite(result.statistic)) {
    result.p_value = gamma_q(0.5 * result.degrees_of_freedom, 0.5 * result.statistic);
  }
  if (!reason.empty()) result.p_value = 0;
  if (!(result.p_value >= kRunLevel)) reason += "the statistic is too large; ";
  std::ostringstream text;
  text << "chi-square " << result.statistic << ", degrees of freedom " << result.degrees_of_freedom << ", p "
       << result.p_value << ", pdf integral " << result.pdf_integral << ", no sample " << bins.missing_observed
       << " of " << options.samples;
  result.report = text.str();
  if (!reason.empty()) result.report += "\n  FAILED: " + reason + worst_bins(bins);
  return result;
}

/// A pdf value, or NaN if it is not a density, so that the sum is NaN as well.
double checked(float density) {
  return density >= 0 && std::isfinite(density) ? static_cast<double>(density)
                                                : std::numeric_limits<double>::quiet_NaN();
}

/// Fills bins.expected with the probability of each bin.
void integrate_bins(const Plane& density, double tolerance, Bins& bins) {
  const double wx = 1.0 / bins.nx, wy = 1.0 / bins.ny;
  const auto probability = [&](size_t i, int min_depth) {
    const auto x = static_cast<double>(i % static_cast<size_t>(bins.nx));
    const auto y = static_cast<double>(i / static_cast<size_t>(bins.nx));
    const Rectangle r{x * wx, (x + 1) * wx, y * wy, (y + 1) * wy};
    return refine(density, r, gauss(density, r), {tolerance, min_depth}, 0);
  };
  double observed = 0, impossible = 0;
  for (size_t i = 0; i < bins.size(); ++i) {
    bins.expected[i] = probability(i, 1);
    observed += bins.observed[i];
    if (bins.expected[i] == 0) impossible += bins.observed[i];
  }
  // The support may reach into a bin by a sliver between the nodes of the rule, so look closer before a few samples are
  // called impossible. Many samples are not from a sliver.
  if (impossible > 1e-3 * observed) return;
  for (size_t i = 0; i < bins.size(); ++i) {
    if (bins.expected[i] == 0 && bins.observed[i] > 0) bins.expected[i] = probability(i, 6);
  }
}

/// `locate` puts a sample into [0,1)^2; `density` is the pdf with respect to area there.
ChiSquareResult run(const std::function<std::optional<Vec2f>(Rng&)>& locate, const Plane& density,
                    const ChiSquareOptions& of_first_run) {
  ChiSquareOptions options = of_first_run;
  options.seed = run_seed(options.seed);
  options.samples = run_samples(options.samples);
  Bins bins{options.bins_x, options.bins_y, {}, {}};
  const size_t count = static_cast<size_t>(bins.nx) * static_cast<size_t>(bins.ny);
  bins.observed.assign(count, 0);
  bins.expected.assign(count, 0);
  Rng rng(options.seed, 0x5eed);
  int outside = 0;
  for (int i = 0; i < options.samples; ++i) {
    const std::optional<Vec2f> at = locate(rng);
    if (!at) {
      ++bins.missing_observed;
    } else if (at->x >= 0 && at->x <= 1 && at->y >= 0 && at->y <= 1) {
      const int x = std::min(static_cast<int>(at->x * static_cast<float>(bins.nx)), bins.nx - 1);
      const int y = std::min(static_cast<int>(at->y * static_cast<float>(bins.ny)), bins.ny - 1);
      ++bins.observed[static_cast<size_t>(y) * static_cast<size_t>(bins.nx) + static_cast<size_t>(x)];
    } else {
      ++outside;
    }
  }
  integrate_bins(density, 0.2 / options.samples, bins);  // to a fifth of one expected sample, at worst
  for (double& expected : bins.expected) expected *= options.samples;
  ChiSquareResult result = judge(bins, options);
  if (outside > 0) {
    result.p_value = 0;
    result.report += "\n  FAILED: " + std::to_string(outside) + " samples outside the domain or not finite";
  }
  return result;
}

}  // namespace

double integrate_rectangle(const std::function<double(double, double)>& f, const double (&x)[2], const double (&y)[2],
                           double tolerance) {
  const Rectangle r{x[0], x[1], y[0], y[1]};
  return refine(f, r, gauss(f, r), {tolerance, 1}, 0);
}

ChiSquareResult chi_square_square(const SquareSampler& sample, const SquarePdf& pdf, const ChiSquareOptions& options) {
  const Plane density = [&](double x, double y) {
    return checked(pdf({static_cast<float>(x), static_cast<float>(y)}));
  };
  return run(sample, density, options);
}

ChiSquareResult chi_square_sphere(const SphereSampler& sample, const SpherePdf& pdf, const ChiSquareOptions& options) {
  const SphereMap map{options.frame, options.pole_exponent};
  const auto locate = [&](Rng& rng) -> std::optional<Vec2f> {
    const std::optional<Vec3f> w = sample(rng);
    if (!w) return std::nullopt;
    return map.locate(*w);
  };
  const Plane density = [&](double x, double y) {
    return checked(pdf(map.direction(x, y))) * map.solid_angle_per_area(y);
  };
  return run(locate, density, options);
}

double integrate_sphere(const std::function<double(const Vec3f&)>& f, const Frame& frame, double pole_exponent) {
  const SphereMap map{frame, pole_exponent};
  const Plane density = [&](double x, double y) { return f(map.direction(x, y)) * map.solid_angle_per_area(y); };
  constexpr int kCells = 16;
  constexpr double kWidth = 1.0 / kCells;
  double sum = 0;
  for (int y = 0; y < kCells; ++y) {
    for (int x = 0; x < kCells; ++x) {
      sum += integrate_rectangle(density, {x * kWidth, (x + 1) * kWidth}, {y * kWidth, (y + 1) * kWidth}, 1e-6);
    }
  }
  return sum;
}

// DLMF 8.7.1 (series for the lower function) below the turning point, the continued fraction 8.9.2 by the modified
// Lentz method above it.
double gamma_q(double a, double x) {
  if (!(x > 0)) return 1;
  const double prefactor = std::exp(a * std::log(x) - x - std::lgamma(a));
  constexpr double kEpsilon = 1e-15;
  if (x < a + 1) {
    double term = 1 / a, sum = term;
    for (int n = 1; n < 100000 && term > sum * kEpsilon; ++n) sum += term *= x / (a + n);
    return std::clamp(1 - prefactor * sum, 0.0, 1.0);
  }
  constexpr double kTiny = 1e-300;
  double b = x + 1 - a, c = 1 / kTiny, d = 1 / b, h = d;
  for (int n = 1; n < 100000; ++n) {
    const double an = -n * (n - a);
    b += 2;
    d = an * d + b;
    d = 1 / (std::abs(d) < kTiny ? kTiny : d);
    c = b + an / c;
    if (std::abs(c) < kTiny) c = kTiny;
    const double factor = d * c;
    h *= factor;
    if (std::abs(factor - 1) < kEpsilon) break;
  }
  return std::clamp(prefactor * h, 0.0, 1.0);
}

}  // namespace alabaster::testing
