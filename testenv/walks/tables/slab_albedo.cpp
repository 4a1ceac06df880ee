// The albedo that each inversion obtains on a half-space, and the cost of its walks.
#include <limits>

#include "testenv/support/albedo_table.h"
#include "testenv/support/half_space.h"
#include "testenv/support/van_de_hulst.h"
#include "testenv/walks/tables/tables.h"
#include "testenv/walks/tables/walks.h"

namespace alabaster::testing {
namespace {

struct Obtained {
  RunningStatistics walked;
  double theory = 0;  // of the half-space; for a white one, without the share that the safety cap ends
  double events = 0, expected_events = 0;
  double rays = 0;
  uint64_t capped = 0, walks = 0;
};

/// The share of a white half-space's walks that is still inside after n events: (4/sqrt 3) / sqrt(pi n), from
/// 1 - A -> (4/sqrt 3) sqrt(1 - alpha) by a Tauberian theorem.
double white_walks_inside_after(double events) {
  return 4 / std::sqrt(3 * kPiDouble * events);
}

Obtained obtain(Report& report, double complement, uint32_t seed) {
  Obtained result;
  const double albedo = half_space_albedo(complement);
  WalkSettings settings = plain_walk();
  double loss = 0;
  if (complement > 0)
    settings.safety_cap = std::numeric_limits<uint32_t>::max();  // no walk is ended by the cap
  else
    loss = white_walks_inside_after(settings.safety_cap);
  result.theory = albedo - loss;
  const WalkTotals totals = walk_bodies([] { return SlabTracer(); }, unit_medium(complement), settings,
                                        report.walks_for(result.theory * (1 - result.theory)), seed);
  result.walked = totals.out[0];
  result.walks = totals.counters.walks;
  result.events = totals.events.mean();
  result.expected_events = complement > 0 ? (1 - albedo) / complement : std::numeric_limits<double>::infinity();
  result.rays = static_cast<double>(totals.counters.walk_rays) / static_cast<double>(result.walks);
  result.capped = totals.counters.walk_safety_cap;
  return result;
}

void print_cost(Report& report, const std::vector<std::vector<Obtained>>& rows) {
  report.heading("Cost: scattering events and rays per walk in a half-space");
  report.paragraph(
      "Theory, for walks that absorption ends: a collision absorbs 1 - alpha of them, and 1 - A are absorbed, so "
      "there\n"
      "are (1 - A)/(1 - alpha) events per walk. The renderer's walks keep their weight instead until a quarter is "
      "left,\n"
      "which is less noise for more events. The mean at A = 1 is infinite: that row is for walks capped at 1e6 "
      "events.");
  report.columns({"requested A", "chiang2016: events", "theory", "rays", "exact: events", "theory", "rays"});
  for (size_t a = 0; a < rows.size(); ++a) {
    std::vector<std::string> cells = {text("%g", kAlbedoTable[a].albedo)};
    for (size_t i = 0; i < 2; ++i) {
      const Obtained& o = rows[a][i];
      cells.push_back(text("%.2f", o.events));
      cells.push_back(text("%.2f", o.expected_events));
      cells.push_back(text("%.2f", o.rays));
    }
    report.row(cells);
  }
}

}  // namespace

void print_slab_albedo(Report& report) {
  report.heading("Requested and obtained albedo, half-space");
  report.paragraph(
      "Walked by the renderer's loop, ± one standard error. Theory: Chandrasekhar's H function (1960) at the\n"
      "inversion's alpha. At A = 1 the safety cap of 1e6 events ends 4/sqrt(3 pi 1e6) = 0.00130 of a half-space's\n"
      "walks under `exact` and van de Hulst's inversion (alpha = 1), which is subtracted from theory. All other rows "
      "run\n"
      "without a cap, which would end 0.0005 of the walks at A = 0.999 and none elsewhere.");
  report.columns({"requested A", "chiang2016", "theory", "z", "exact", "theory", "z", "van de Hulst", "theory", "z"});
  std::vector<std::vector<Obtained>> rows;
  uint32_t seed = 1000;
  for (const AlbedoRow& row : kAlbedoTable) {
    std::vector<std::string> cells = {text("%g", row.albedo)};
    rows.emplace_back();
    for (const double complement :
         {one_minus_alpha(row.albedo, AlbedoInversion::chiang2016), one_minus_alpha(row.albedo, AlbedoInversion::exact),
          van_de_hulst_complement(row.albedo)}) {
      const Obtained o = obtain(report, complement, ++seed);
      cells.push_back(Estimate(o.walked).text());
      cells.push_back(text("%.6f", o.theory));
      cells.push_back(report.z_share(o.walked, o.theory));
      report.require(o.walked.standard_error() < 1.3 * report.sigma(), text("standard error at A = %g", row.albedo));
      if (o.expected_events < std::numeric_limits<double>::infinity())
        report.require(o.capped == 0, text("no walk capped at A = %g", row.albedo));
      rows.back().push_back(o);
    }
    report.row(cells);
  }
  print_cost(report, rows);
}

}  // namespace alabaster::testing
