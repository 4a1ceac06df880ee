// Noise and cost of the two choices of channel weights on skin, in a half-space under two lights.
#include "testenv/statistical/tables/report.h"
#include "testenv/statistical/tables/walks.h"

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

LitTotals walk_lit(const Skin& skin, WalkWeights weights, uint64_t walks, uint32_t seed) {
  const Medium medium = make_medium(skin.albedo, skin.distance, AlbedoInversion::exact);
  WalkSettings settings;
  settings.weights = weights;
  return run_chunks<LitTotals>(walks, seed, [&](Rng& rng, LitTotals& totals) {
    SlabTracer tracer;
    const auto end = walk_body(tracer, SlabTracer::entry(), medium, settings, rng, totals.counters);
    const bool lit = end && tracer.position().x + static_cast<double>(end->direction.x) * end->hit.t >
                                0.5 * static_cast<double>(skin.distance.r);
    for (size_t c = 0; c < 3; ++c) {
      totals.uniform[c].add(end ? end->throughput[c] : 0);
      totals.edge[c].add(lit ? end->throughput[c] : 0);
    }
  });
}

/// As a cell; "-" where a channel hardly gets there.
std::string relative_variance(const RunningStatistics (&channels)[3]) {
  double sum = 0;
  for (const RunningStatistics& c : channels) {
    if (!(c.standard_error() < 0.2 * c.mean())) return "-";
    sum += c.variance() / (c.mean() * c.mean()) / 3;
  }
  return text("%.3f", sum);
}

}  // namespace

void print_chromatic_weights(Report& report) {
  const Skin skins[] = {{"skin", {0.9f, 0.6f, 0.45f}, {1.0f, 0.35f, 0.2f}},
                        {"pale skin", {0.95f, 0.75f, 0.6f}, {1.0f, 0.35f, 0.2f}},
                        {"skin, d = (1, .03, .01)", {0.9f, 0.6f, 0.45f}, {1.0f, 0.03f, 0.01f}}};
  struct Weights {
    const char* name;
    WalkWeights weights;
  };
  constexpr Weights kWeights[] = {{"T alpha (the paper's)", WalkWeights::throughput_times_albedo},
                                  {"T (the default)", WalkWeights::throughput}};
  report.heading("Channel weights of the distance sampling, half-space");
  report.paragraph(
      "Relative variance of one walk (mean over channels of variance / mean²) under uniform light and behind a hard\n"
      "shadow edge at x = d_red / 2; the largest throughput seen at any event or exit. The bound of both is 3 in a\n"
      "half-space; `T` keeps it in every geometry. z: the albedo asked; for the edge the two means against each "
      "other.");
  report.columns({"medium", "weights", "A red", "z", "green", "z", "blue", "z", "variance, uniform", "variance, edge",
                  "z edge (r, g, b)", "events", "rays", "largest T"});
  uint32_t seed = 3000;
  for (const Skin& skin : skins) {
    LitTotals first;
    for (const Weights& choice : kWeights) {
      const LitTotals t = walk_lit(skin, choice.weights, report.walks_for(0.08), ++seed);
      std::vector<std::string> cells = {skin.name, choice.name};
      for (int c = 0; c < 3; ++c) {
        const Estimate albedo = t.uniform[c];
        cells.push_back(albedo.text());
        cells.push_back(report.z(albedo, static_cast<double>(skin.albedo[c])));
      }
      cells.push_back(relative_variance(t.uniform));
      cells.push_back(relative_variance(t.edge));
      std::string edges;
      for (size_t c = 0; c < 3 && choice.weights == WalkWeights::throughput; ++c)
        edges += report.z_between(t.edge[c], first.edge[c]) + " ";
      cells.push_back(edges);
      const auto walks = static_cast<double>(t.counters.walks);
      cells.push_back(text("%.1f", static_cast<double>(t.counters.walk_events) / walks));
      cells.push_back(text("%.1f", static_cast<double>(t.counters.walk_rays) / walks));
      cells.push_back(text("%.3f", t.counters.max_walk_weight));
      report.require(t.counters.max_walk_weight <= 3 * (1 + 1e-9), "weights stay below 3");
      report.row(cells);
      first = t;
    }
  }
}

}  // namespace alabaster::testing
