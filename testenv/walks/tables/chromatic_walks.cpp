// Noise and cost of the walk on skin and marble in a half-space, under two lights, without shortcuts and
// with them.
#include <limits>

#include "testenv/walks/tables/tables.h"
#include "testenv/walks/tables/walks.h"

namespace alabaster::testing {
namespace {

struct Skin {
  const char* name;
  Rgb albedo, distance;
};

/// Two lights: one everywhere, and one that is dark for x < d_red / 2: a hard shadow edge.
struct LitTotals {
  RunningStatistics uniform[3], edge[3];
  RenderCounters counters;

  void merge(const LitTotals& o) {
    for (size_t c = 0; c < 3; ++c) {
      uniform[c].merge(o.uniform[c]);
      edge[c].merge(o.edge[c]);
    }
    counters.add(o.counters);
  }
};

LitTotals walk_lit(const Skin& skin, const WalkSettings& settings, uint64_t walks, uint32_t seed) {
  const Medium medium = make_medium(skin.albedo, skin.distance, AlbedoInversion::exact);
  return run_chunks<LitTotals>(walks, seed, [&](Rng& rng, LitTotals& totals) {
    SlabTracer tracer;
    const auto end = walk_body_with_shortcuts(tracer, medium, settings, rng, totals.counters);
    const bool lit = end && tracer.position().x + static_cast<double>(end->direction.x) * end->hit.t >
                                0.5 * static_cast<double>(skin.distance.r);
    for (size_t c = 0; c < 3; ++c) {
      totals.uniform[c].add(end ? end->throughput[c] : 0);
      totals.edge[c].add(lit ? end->throughput[c] : 0);
    }
  });
}

/// Infinite where hardly any light of a channel arrives.
double relative_variance(const RunningStatistics (&channels)[3]) {
  double sum = 0;
  for (const RunningStatistics& c : channels) {
    if (!(c.standard_error() < 0.2 * c.mean())) return std::numeric_limits<double>::infinity();
    sum += c.variance() / (c.mean() * c.mean()) / 3;
  }
  return sum;
}

/// The kinds of walks. The first is the base of the comparisons.
struct Choice {
  const char* name;
  WalkSettings settings;
  double bias;   // of an albedo, at most
  double bound;  // of a throughput
};

std::vector<Choice> choices() {
  std::vector<Choice> all = {{"plain", plain_walk(), 0, 3},
                             {"guided", plain_walk(), 0, WalkGuide::kLargestSum},
                             {"sphere steps", plain_walk(), 1e-4, 3},
                             {"both (the default)", WalkSettings(), 1e-4, WalkGuide::kLargestSum}};
  all[1].settings.guiding = true;
  all[2].settings.sphere_steps = true;
  return all;
}

/// Cost in steps: rays, and lookups of the distance that spheres need.
double steps(const LitTotals& t) {
  return static_cast<double>(t.counters.walk_rays + t.counters.walk_sphere_steps) /
         static_cast<double>(t.counters.walks);
}

std::vector<std::string> cells_of(Report& report, const Skin& skin, const Choice& choice, const LitTotals& t,
                                  const LitTotals& first) {
  std::vector<std::string> cells = {skin.name, choice.name};
  for (int c = 0; c < 3; ++c) {
    cells.push_back(Estimate(t.uniform[c]).text());
    cells.push_back(report.z(t.uniform[c], static_cast<double>(skin.albedo[c]), choice.bias + 1e-6));
  }
  const double uniform = relative_variance(t.uniform), edge = relative_variance(t.edge);
  cells.push_back(text("%.3f", uniform));
  cells.push_back(text("%.3g", edge));
  std::string edges;
  for (size_t c = 0; c < 3 && &t != &first; ++c)
    if (std::isfinite(edge)) edges += report.z_between(t.edge[c], first.edge[c]) + " ";
  cells.push_back(edges);
  cells.push_back(text("%.1f", static_cast<double>(t.counters.walk_rays) / static_cast<double>(t.counters.walks)));
  cells.push_back(text("%.1f", steps(t)));
  cells.push_back(text("%.2f", relative_variance(first.uniform) * steps(first) / (uniform * steps(t))));
  cells.push_back(std::isfinite(edge) ? text("%.2f", relative_variance(first.edge) * steps(first) / (edge * steps(t)))
                                      : "-");
  cells.push_back(text("%.3f", t.counters.max_walk_weight));
  report.require(t.counters.max_walk_weight <= choice.bound * (1 + 1e-9), text("weights of %s", choice.name));
  return cells;
}

}  // namespace

void print_chromatic_walks(Report& report) {
  const Skin skins[] = {{"skin", {0.9f, 0.6f, 0.45f}, {1.0f, 0.35f, 0.2f}},
                        {"pale skin", {0.95f, 0.75f, 0.6f}, {1.0f, 0.35f, 0.2f}},
                        {"marble", {0.99f, 0.97f, 0.9f}, {1.0f, 0.9f, 0.8f}},
                        {"skin, d = (1, .03, .01)", {0.9f, 0.6f, 0.45f}, {1.0f, 0.03f, 0.01f}}};
  report.heading("Guiding and sphere steps: noise and cost in a half-space");
  report.paragraph(
      "Relative variance of one walk (mean over channels of variance / mean²) under uniform light and behind a hard\n"
      "shadow edge at x = d_red / 2. Gain: variance times steps of the plain walk over that of the row. Steps\n"
      "are rays and distance lookups (the benchmark measures seconds). z: against the requested albedo, and at the\n"
      "edge (r, g, b) against the first row. Largest T: the throughput at any event or exit.");
  report.columns({"medium", "walk", "A red", "z", "green", "z", "blue", "z", "variance, uniform", "edge", "z edge",
                  "rays", "steps", "gain, uniform", "gain, edge", "largest T"});
  uint32_t seed = 3000;
  for (const Skin& skin : skins) {
    // A walk in marble is ten times as long as one in skin.
    const uint64_t walks = report.walks_for(0.08, skin.albedo.r > 0.98f ? 2.5 : 1);
    LitTotals first;
    for (const Choice& choice : choices()) {
      const LitTotals t = walk_lit(skin, choice.settings, walks, ++seed);
      if (first.counters.walks == 0) {
        first = t;
        report.row(cells_of(report, skin, choice, first, first));
      } else {
        report.row(cells_of(report, skin, choice, t, first));
      }
    }
  }
}

}  // namespace alabaster::testing
