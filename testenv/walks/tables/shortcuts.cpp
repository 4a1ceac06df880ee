// Guiding and sphere steps in grey media: their cost by albedo, and the largest weight.
#include "testenv/walks/tables/tables.h"
#include "testenv/walks/tables/walks.h"

namespace alabaster::testing {
namespace {

/// Sphere steps leave out a boundary layer.
constexpr double kBias = 1e-4;

WalkSettings with(bool guiding, bool sphere_steps) {
  WalkSettings settings;
  settings.guiding = guiding;
  settings.sphere_steps = sphere_steps;
  return settings;
}

double per_walk(uint64_t count, const WalkTotals& t) {
  return static_cast<double>(count) / static_cast<double>(t.counters.walks);
}

void print_costs(Report& report, uint32_t seed) {
  struct Mode {
    const char* name;
    WalkSettings settings;
    bool long_walks;  // near-white walks are as long as the plain ones
  };
  const Mode modes[] = {{"guiding", with(true, false), true},
                        {"sphere steps", with(false, true), false},
                        {"both", with(true, true), false}};
  report.heading("Shortcuts: cost by albedo, half-space, one channel");
  report.paragraph(
      "Means per walk, `exact` inversion. Plain, by theory: (1 - A)/(1 - alpha) events, and A more rays. A shortcut\n"
      "is taken where it pays, so some rows are plain. z: the albedo obtained against A; sphere steps may err by\n"
      "1e-4.");
  report.columns({"A", "plain: rays", "walk", "albedo", "z", "events", "sphere steps", "rays", "largest T"});
  for (const double albedo : {0.2, 0.5, 0.8, 0.9, 0.95, 0.99, 0.999, 1.0}) {
    const double complement = one_minus_alpha(albedo, AlbedoInversion::exact);
    for (const Mode& mode : modes) {
      if (mode.long_walks && albedo > 0.98) continue;
      const WalkTotals t = walk_bodies([] { return SlabTracer(); }, unit_medium(complement), mode.settings,
                                       report.walks_for(0.25), ++seed);
      report.require(t.counters.walk_safety_cap == 0, "no walk with shortcuts meets the safety cap");
      report.row(
          {text("%g", albedo), complement > 0 ? text("%.1f", (1 - albedo) / complement + albedo) : "inf", mode.name,
           Estimate(t.out[0]).text(), report.z(t.out[0], albedo, 1e-6 + (mode.settings.sphere_steps ? kBias : 0)),
           text("%.2f", per_walk(t.counters.walk_events, t)), text("%.2f", per_walk(t.counters.walk_sphere_steps, t)),
           text("%.2f", per_walk(t.counters.walk_rays, t)), text("%.3f", t.counters.max_walk_weight)});
    }
  }
}

void print_largest_weights(Report& report, uint32_t seed) {
  struct Case {
    const char* name;
    Rgb albedo, distance;
    double thickness;
  };
  const Case cases[] = {
      {"skin, half-space", {0.9f, 0.6f, 0.45f}, {1.0f, 0.35f, 0.2f}, std::numeric_limits<double>::infinity()},
      {"skin, slab of 2 d_red", {0.9f, 0.6f, 0.45f}, {1.0f, 0.35f, 0.2f}, 2},
      {"d a hundredfold apart, slab", {0.9f, 0.3f, 0.6f}, {1.0f, 0.01f, 0.1f}, 1}};
  report.heading("Shortcuts: the largest weight of many walks");
  report.paragraph("All shortcuts on. The throughput at any event or exit of a walk that enters with throughput 1.");
  report.columns({"body", "walks", "largest T", "bound"});
  for (const Case& c : cases) {
    const uint64_t walks = report.walks_for(1.34);
    const WalkTotals t = walk_bodies([&] { return SlabTracer(c.thickness); },
                                     make_medium(c.albedo, c.distance, AlbedoInversion::exact), {}, walks, ++seed);
    report.row({c.name, text("%.3g", static_cast<double>(walks)), text("%.3f", t.counters.max_walk_weight),
                text("%g", static_cast<double>(WalkGuide::kLargestSum))});
    report.require(t.counters.max_walk_weight <= WalkGuide::kLargestSum, "weights stay within their bound");
  }
}

}  // namespace

void print_shortcuts(Report& report) {
  print_costs(report, 3500);
  print_largest_weights(report, 3600);
}

}  // namespace alabaster::testing
