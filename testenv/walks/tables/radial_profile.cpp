// The distance from entry to exit on a half-space: the walk compared with Burley's normalized diffusion, which has the
// same parameters A and d. Section 4 of the paper calls the two identical on a slab.
#include <array>

#include "testenv/walks/tables/tables.h"
#include "testenv/walks/tables/walks.h"

namespace alabaster::testing {
namespace {

constexpr int kDecades = 6, kBinsPerDecade = 20;  // of r/d, from 1e-3 on
constexpr size_t kBins = kDecades * kBinsPerDecade + 2;

/// Burley 2015: R(r) = A (e^{-r/d} + e^{-r/3d}) / (8 pi d r); the share of it within r, here in units of d.
double burley_within(double r) {
  return 1 - 0.25 * std::exp(-r) - 0.75 * std::exp(-r / 3);
}

double bin_start(size_t bin) {  // of bins 1..
  return 1e-3 * std::pow(10.0, static_cast<double>(bin - 1) / kBinsPerDecade);
}

double burley_in_bin(size_t bin) {
  const double from = bin == 0 ? 0 : burley_within(bin_start(bin));
  return (bin + 1 == kBins ? 1 : burley_within(bin_start(bin + 1))) - from;
}

/// Light by the distance at which it leaves.
struct Histogram {
  std::array<double, kBins> light{};
  double sum = 0, sum_of_squares = 0, sum_of_radii = 0;

  void add(double r, double weight) {
    const double position = (std::log10(r) + 3) * kBinsPerDecade + 1;
    light[static_cast<size_t>(std::clamp(position, 0.0, static_cast<double>(kBins - 1)))] += weight;
    sum += weight;
    sum_of_squares += weight * weight;
    sum_of_radii += weight * r;
  }
  void merge(const Histogram& o) {
    for (size_t i = 0; i < kBins; ++i) light[i] += o.light[i];
    sum += o.sum;
    sum_of_squares += o.sum_of_squares;
    sum_of_radii += o.sum_of_radii;
  }
  double share(size_t bin) const { return light[bin] / sum; }
  double mean_radius() const { return sum_of_radii / sum; }
  /// The number of walks of equal weight that would be as noisy.
  double effective_walks() const { return sum * sum / sum_of_squares; }
};

Histogram walk_radii(float albedo, uint64_t walks, uint32_t seed) {
  const Medium medium = make_medium(Rgb(albedo), {1, 0, 0}, AlbedoInversion::exact);
  return run_chunks<Histogram>(walks, seed, [&](Rng& rng, Histogram& histogram) {
    SlabTracer tracer;
    RenderCounters counters;
    const auto end = walk_body(tracer, medium, {}, rng, counters);
    if (!end) return;
    const Vec3d exit = tracer.position() + to_double(end->direction) * end->hit.t;
    histogram.add(std::hypot(exit.x, exit.y), end->throughput[0]);
  });
}

/// Sum over bins of |walked - Burley|. One half of the walks gives the signs and the other the shares, so that noise
/// does not add up to a difference.
double signed_difference(const Histogram& signs, const Histogram& shares) {
  double sum = 0;
  for (size_t i = 0; i < kBins; ++i)
    sum += std::copysign(1.0, signs.share(i) - burley_in_bin(i)) * (shares.share(i) - burley_in_bin(i));
  return sum;
}

std::string decade_cell(const Histogram& walked, int decade) {
  double share = 0, burley = 0;
  for (int i = 0; i < kBinsPerDecade; ++i) {
    const auto bin = static_cast<size_t>(1 + decade * kBinsPerDecade + i);
    share += walked.share(bin);
    burley += burley_in_bin(bin);
  }
  return text("%.4f / %.4f", share, burley);
}

}  // namespace

void print_radial_profile(Report& report) {
  struct Row {
    float albedo;
    double difference;  // measured to three digits with another program and other bins, 2e7 walks
  };
  constexpr Row kRows[] = {{0.2f, .028}, {0.5f, .037}, {0.8f, .039}, {0.95f, .159}};
  constexpr double kRowError = 1.5e-3;

  report.heading("Radial profile of a half-space: walked / Burley's");
  report.paragraph(
      "Shares of the light that leaves, by decades of r/d, with the `exact` inversion and cosine entry. L1: the sum\n"
      "of absolute differences of the shares over 122 bins, 0 for equal profiles and 2 for disjoint ones. Burley's\n"
      "profile has no long tail, so the two diverge at A = 0.95; below that they differ by less than 4 %.");
  report.columns({"A", "[.001,.01)", "[.01,.1)", "[.1,1)", "[1,10)", "[10,100)", "L1", "z", "mean radius / mfp"});
  uint32_t seed = 2000;
  for (const Row& row : kRows) {
    const uint64_t walks = report.walks_for(0.25, 0.5);
    Histogram halves[2] = {walk_radii(row.albedo, walks, ++seed), walk_radii(row.albedo, walks, ++seed)};
    const double difference = 0.5 * (signed_difference(halves[0], halves[1]) + signed_difference(halves[1], halves[0]));
    Histogram all = halves[0];
    all.merge(halves[1]);
    const Estimate measured(difference, 1 / std::sqrt(all.effective_walks()));
    const double mean_free_path = distance_scale(row.albedo);
    std::vector<std::string> cells = {text("%g", row.albedo)};
    for (int decade = 0; decade < 5; ++decade) cells.push_back(decade_cell(all, decade));
    cells.push_back(text("%.4f ± %.4f", measured.mean, measured.sigma));
    cells.push_back(report.z(measured, row.difference, kRowError));
    cells.push_back(text("%.3f", all.mean_radius() / mean_free_path));
    report.row(cells);
  }
}

}  // namespace alabaster::testing
