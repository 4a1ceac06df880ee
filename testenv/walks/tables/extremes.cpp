// The ends of the parameters' ranges, where a walk that is merely plausible fails.
#include "testenv/support/transport_solution.h"
#include "testenv/walks/tables/tables.h"
#include "testenv/walks/tables/walks.h"

namespace alabaster::testing {
namespace {

double exact_complement(double albedo) {
  return one_minus_alpha(albedo, AlbedoInversion::exact);
}

/// A dark channel's albedo, carried by walks that a bright channel of the same extinction keeps alive.
void print_dark_channel(Report& report, uint32_t seed) {
  report.heading("Extremes: a nearly black channel");
  report.paragraph(
      "Obtained over requested albedo in a half-space, beside channels of A = 0.9 and 0.5 with the same extinction.");
  report.columns({"requested A", "alpha, exact", "alpha, eq. 1", "obtained / requested", "z"});
  for (const float albedo : {1e-2f, 1e-4f, 1e-6f}) {
    const auto asked = static_cast<double>(albedo);
    const Rgb albedos(0.9f, albedo, 0.5f);
    Rgb distances;
    for (int c = 0; c < 3; ++c) distances[c] = static_cast<float>(1 / distance_scale(static_cast<double>(albedos[c])));
    const Medium medium = make_medium(albedos, distances, AlbedoInversion::exact);
    const WalkTotals t = walk_bodies([] { return SlabTracer(); }, medium, plain_walk(), report.walks_for(0.25), ++seed);
    const Estimate ratio(t.out[1].mean() / asked, t.out[1].standard_error() / asked);
    report.row({text("%g", asked), text("%.4g", 1 - exact_complement(asked)),
                text("%.4g", 1 - one_minus_alpha(asked, AlbedoInversion::chiang2016)), ratio.text(),
                report.z(ratio, 1, 1e-6)});
  }
}

/// With d so long that hardly any light collides, the loss is (1 - alpha) sigma_t times the mean chord.
void print_clear_sphere(Report& report, uint32_t seed) {
  report.heading("Extremes: a nearly clear sphere");
  report.paragraph(
      "tau = 1e-3: light passes at any A, so the colour is lost. Ratio: 1 - A_eff over (1 - alpha) 4/3 tau; the\n"
      "second order is less than 2 tau of it.");
  report.columns({"A", "lost", "ratio", "z"});
  constexpr double kTau = 1e-3;
  for (const double albedo : {0.2, 0.5}) {
    const double expected = exact_complement(albedo) * 4 / 3 * kTau;
    const WalkTotals t = walk_bodies([] { return SphereTracer(kTau); }, unit_medium(exact_complement(albedo)),
                                     plain_walk(), report.walks_for(0.25, 0.3), ++seed);
    const double lost = 1 - t.out[0].mean();
    const double sigma = std::sqrt(expected / static_cast<double>(t.out[0].count()));
    const Estimate ratio(lost / expected, sigma / expected);
    report.row({text("%g", albedo), text("%.6f", lost), ratio.text(), report.z(ratio, 1, 2 * kTau)});
  }
}

/// Distances four decades apart in one body: each channel must equal that channel alone, and weights must be bounded.
void print_mixed_distances(Report& report, uint32_t seed) {
  struct Mixture {
    Rgb albedo, distance;
    float radius;
  };
  const Mixture mixtures[] = {{{0.9f, 0.9f, 0.01f}, {0.01f, 0.01f, 100.0f}, 0.05f},
                              {{0.9f, 0.5f, 0.2f}, {0.01f, 1.0f, 100.0f}, 0.05f},
                              {{0.99f, 0.01f, 0.5f}, {100.0f, 0.01f, 1.0f}, 0.3f}};
  struct Choice {
    const char* name;
    WalkSettings settings;
  };
  const Choice choices[] = {{"plain", plain_walk()}, {"shortcuts", WalkSettings()}};
  report.heading("Extremes: scatter distances four decades apart in a thin sphere");
  report.paragraph(
      "Each channel of a chromatic walk compared with that channel alone (integral equation). The largest\n"
      "throughput is bounded by 3, and by a constant with guiding.");
  report.columns({"A, d, radius", "walk", "red", "theory", "z", "green", "theory", "z", "blue", "theory", "z",
                  "largest T", "bound"});
  for (const Mixture& m : mixtures)
    for (const Choice& choice : choices) {
      const Medium medium = make_medium(m.albedo, m.distance, AlbedoInversion::exact);
      const auto radius = static_cast<double>(m.radius);
      const WalkTotals t =
          walk_bodies([&] { return SphereTracer(radius); }, medium, choice.settings, report.walks_for(0.25), ++seed);
      std::vector<std::string> cells = {
          text("(%g, %g, %g), (%g, %g, %g), %g", static_cast<double>(m.albedo.r), static_cast<double>(m.albedo.g),
               static_cast<double>(m.albedo.b), static_cast<double>(m.distance.r), static_cast<double>(m.distance.g),
               static_cast<double>(m.distance.b), radius),
          choice.name};
      for (int c = 0; c < 3; ++c) {
        const double complement = exact_complement(static_cast<double>(m.albedo[c]));
        const SphereAnswer answer = solve_sphere(radius * static_cast<double>(medium.sigma_t[c]), complement);
        cells.push_back(Estimate(t.out[c]).text());
        cells.push_back(text("%.5f", answer.albedo));
        cells.push_back(report.z(t.out[c], answer.albedo, answer.error + (choice.settings.sphere_steps ? 1e-4 : 1e-6)));
      }
      double bound = 3;
      if (choice.settings.guiding) bound = WalkGuide::kLargestSum;
      cells.push_back(text("%.3f", t.counters.max_walk_weight));
      cells.push_back(text("%.3f", bound));
      report.require(t.counters.max_walk_weight <= bound * (1 + 1e-6), "weights stay within their bound");
      report.row(cells);
    }
}

}  // namespace

void print_extremes(Report& report) {
  print_dark_channel(report, 7000);
  print_clear_sphere(report, 7100);
  print_mixed_distances(report, 7200);
}

}  // namespace alabaster::testing
