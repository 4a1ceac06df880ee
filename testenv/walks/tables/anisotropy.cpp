// Henyey-Greenstein scattering in a half-space at equal albedo and scatterDistance: the albedo obtained, the distance
// from entry to exit, and the cost.
#include "testenv/support/anisotropic_half_space.h"
#include "testenv/support/van_de_hulst.h"
#include "testenv/walks/tables/tables.h"
#include "testenv/walks/tables/walks.h"

namespace alabaster::testing {
namespace {

constexpr float kAsymmetries[] = {-0.9f, -0.7f, -0.5f, -0.3f, 0.0f, 0.3f, 0.5f, 0.7f, 0.9f};
constexpr float kAlbedos[] = {0.05f, 0.2f, 0.5f, 0.8f, 0.95f};
constexpr size_t kIsotropic = 4;

struct Totals {
  RunningStatistics out, radius, log_radius;  // distances from entry to exit, in units of scatterDistance
  RenderCounters counters;
  void merge(const Totals& o) {
    out.merge(o.out);
    radius.merge(o.radius);
    log_radius.merge(o.log_radius);
    counters.add(o.counters);
  }
};

Totals walk_half_space(const Medium& medium, uint64_t count, uint32_t seed) {
  return run_chunks<Totals>(count, seed, [&](Rng& rng, Totals& totals) {
    SlabTracer tracer;
    const auto end = walk_body(tracer, medium, {}, rng, totals.counters);
    totals.out.add(end ? end->throughput[0] : 0);
    if (!end) return;
    const Vec3d exit = tracer.position() + to_double(end->direction) * end->hit.t;
    const double radius = std::hypot(exit.x, exit.y);
    totals.radius.add(radius);
    if (radius > 0) totals.log_radius.add(std::log(radius));
  });
}

using Row = std::array<Totals, std::size(kAsymmetries)>;

void print_radii(Report& report, const std::array<Row, std::size(kAlbedos)>& rows) {
  report.heading("Distance from entry to exit by g, in units of scatterDistance");
  report.paragraph(
      "Mean ± one standard error; in brackets the geometric mean relative to that at g = 0. Eq. 3 gives sigma_t\n"
      "(1-g), so both would be constant along a row if similarity were exact.");
  std::vector<std::string> names = {"A"};
  for (const float g : kAsymmetries) names.push_back(text("g = %g", static_cast<double>(g)));
  report.columns(names);
  for (size_t a = 0; a < rows.size(); ++a) {
    std::vector<std::string> cells = {text("%g", static_cast<double>(kAlbedos[a]))};
    for (const Totals& t : rows[a])
      cells.push_back(text("%.3f ± %.3f (%.2f)", t.radius.mean(), t.radius.standard_error(),
                           std::exp(t.log_radius.mean() - rows[a][kIsotropic].log_radius.mean())));
    report.row(cells);
  }
}

}  // namespace

void print_anisotropy(Report& report) {
  report.heading("Requested and obtained albedo by g, half-space");
  report.paragraph(
      "`exact` inversion. Solved: the transport equation by invariant embedding, at the inversion's alpha. Walked:\n"
      "the renderer's loop, ± one standard error, z against the solution. The last columns are the result of\n"
      "similarity alone (van de Hulst's inversion, including its own error of up to 0.002 at g = 0) and the cost of a "
      "walk.");
  report.columns(
      {"requested A", "g", "1 - alpha", "solved - requested", "walked", "z", "similarity alone - requested", "events"});
  std::array<Row, std::size(kAlbedos)> rows;
  uint32_t seed = 9000;
  for (size_t a = 0; a < rows.size(); ++a)
    for (size_t i = 0; i < rows[a].size(); ++i) {
      const double albedo = kAlbedos[a], g = kAsymmetries[i];
      const Medium medium = make_medium(Rgb(kAlbedos[a]), {1, 0, 0}, AlbedoInversion::exact, kAsymmetries[i]);
      Totals& totals = rows[a][i];
      totals = walk_half_space(medium, report.walks_for(albedo * (1 - albedo), 3), ++seed);
      const double complement = one_minus_alpha(albedo, AlbedoInversion::exact, g);
      const double solved = anisotropic_half_space_albedo(complement, g);
      const double similar = anisotropic_half_space_albedo(van_de_hulst_complement(albedo, g), g);
      report.row(
          {text("%g", albedo), text("%g", g), text("%.9f", complement), text("%+.1e", solved - albedo),
           Estimate(totals.out).text(), report.z_share(totals.out, solved, 1e-6), text("%+.4f", similar - albedo),
           text("%.1f", static_cast<double>(totals.counters.walk_events) / static_cast<double>(totals.out.count()))});
      report.require(std::abs(solved - albedo) < 2.1e-5, text("albedo obtained at A = %g, g = %g", albedo, g));
      report.require(totals.counters.walk_safety_cap == 0, text("no walk capped at A = %g, g = %g", albedo, g));
    }
  print_radii(report, rows);
}

}  // namespace alabaster::testing
