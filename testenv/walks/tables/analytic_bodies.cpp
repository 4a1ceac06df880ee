// Thin slabs, spheres and the 90-degree edge by the renderer's loop, in bodies traced in double precision.
#include "testenv/support/transport_solution.h"
#include "testenv/walks/tables/tables.h"
#include "testenv/walks/tables/walks.h"

namespace alabaster::testing {
namespace {

void print_slabs(Report& report, uint32_t seed) {
  report.heading("Thin slabs");
  report.paragraph(
      "Thickness L in mean free paths, cosine entry. Theory: the integral equation of the collision density, and\n"
      "2 E3(L) for light that crosses without a collision. A = 1 absorbs nothing, so R + T = 1.");
  report.columns({"A", "L", "R", "theory", "z", "T", "theory", "z", "no collision", "2 E3(L)", "z"});
  for (const double albedo : {0.2, 0.5, 0.9, 1.0})
    for (const double thickness : {1.0, 4.0, 10.0}) {
      const double complement = one_minus_alpha(albedo, AlbedoInversion::exact);
      const SlabAnswer answer = solve_slab(thickness, complement);
      const WalkTotals t = walk_bodies([&] { return SlabTracer(thickness); }, unit_medium(complement), plain_walk(),
                                       report.walks_for(0.25), ++seed);
      report.row({text("%g", albedo), text("%g", thickness), Estimate(t.back).text(), text("%.6f", answer.reflectance),
                  report.z_share(t.back, answer.reflectance, answer.error), Estimate(t.through).text(),
                  text("%.6f", answer.transmittance), report.z_share(t.through, answer.transmittance, answer.error),
                  Estimate(t.uncollided).text(), text("%.6f", slab_zero_scatter(thickness)),
                  report.z_share(t.uncollided, slab_zero_scatter(thickness))});
      if (albedo == 1)
        report.require(t.counters.walk_exits == t.counters.walks && std::abs(t.out[0].mean() - 1) < 1e-12, "R + T = 1");
    }
}

void print_spheres(Report& report, uint32_t seed) {
  constexpr double kAlbedos[] = {0.2, 0.5, 0.8, 0.95};
  report.heading("Spheres in uniform surroundings");
  report.paragraph(
      "Radius tau in mean free paths. Share of the entering light that leaves: walked, theory (integral equation),\n"
      "z; then the share that crosses without a collision against (1 - (1 + 2 tau) e^(-2 tau)) / (2 tau²).");
  report.columns({"tau", "A = .2", "theory", "z", "A = .5", "theory", "z", "A = .8", "theory", "z", "A = .95", "theory",
                  "z", "no collision", "theory", "z"});
  for (const double radius : {0.1, 1.0, 3.0, 10.0, 30.0, 100.0}) {
    std::vector<std::string> cells = {text("%g", radius)};
    RunningStatistics uncollided;
    for (const double albedo : kAlbedos) {
      const double complement = one_minus_alpha(albedo, AlbedoInversion::exact);
      const SphereAnswer answer = solve_sphere(radius, complement);
      const WalkTotals t = walk_bodies([&] { return SphereTracer(radius); }, unit_medium(complement), plain_walk(),
                                       report.walks_for(answer.albedo * (1 - answer.albedo)), ++seed);
      cells.push_back(Estimate(t.out[0]).text());
      cells.push_back(text("%.5f", answer.albedo));
      cells.push_back(report.z_share(t.out[0], answer.albedo, answer.error));
      uncollided.merge(t.uncollided);
    }
    cells.push_back(Estimate(uncollided).text());
    cells.push_back(text("%.6f", sphere_zero_scatter(radius)));
    cells.push_back(report.z_share(uncollided, sphere_zero_scatter(radius)));
    report.row(cells);
  }
}

struct ChordTotals {
  RunningStatistics length, collisions;
  void merge(const ChordTotals& o) {
    length.merge(o.length);
    collisions.merge(o.collisions);
  }
};

void print_chords(Report& report, uint32_t seed) {
  report.heading("Mean path inside a sphere that absorbs nothing");
  report.paragraph(
      "The mean path is 4 V / S = 4/3 radius for any mean free path (Blanco and Fournier 2003). Listed are the path\n"
      "length over it, and collisions over sigma_t times it. Both should be 1.");
  report.columns({"tau", "length", "z", "collisions", "z"});
  for (const double radius : {0.01, 0.1, 1.0, 10.0, 30.0, 100.0}) {
    const double chord = 4.0 / 3 * radius;
    const auto walk = [&](Rng& rng, ChordTotals& totals) {
      SphereTracer tracer(radius);
      RenderCounters counters;
      const auto end = walk_body(tracer, unit_medium(0), plain_walk(), rng, counters);
      totals.length.add(tracer.path_length() / chord);
      totals.collisions.add(end->events / chord);
    };
    // The relative variance of a walk's length grows with the radius, and so do its steps.
    const uint64_t walks = report.walks_for(0.1, radius > 10 ? 3 : 1);
    const ChordTotals t = run_chunks<ChordTotals>(walks, ++seed, walk);
    report.row({text("%g", radius), Estimate(t.length).text(), report.z(t.length, 1), Estimate(t.collisions).text(),
                report.z(t.collisions, 1)});
  }
}

void print_edges(Report& report, uint32_t seed) {
  report.heading("90-degree edge");
  report.paragraph(
      "Albedo at a distance from the edge of a quarter space, in mean free paths. Less medium absorbs there, so\n"
      "edges are brighter than the half-space. `known`: by another program, ± 1e-4.");
  report.columns({"A", "distance", "albedo", "known", "z"});
  struct Row {
    double albedo, distance, known;
  };
  constexpr Row kRows[] = {{0.8, 1, .9243}, {0.95, 1, .9928}, {0.5, 1, 0}, {0.8, 0.25, 0}, {0.8, 4, 0}};
  for (const Row& row : kRows) {
    const WalkTotals t = walk_bodies([&] { return EdgeTracer(row.distance); },
                                     unit_medium(one_minus_alpha(row.albedo, AlbedoInversion::exact)), plain_walk(),
                                     report.walks_for(0.08), ++seed);
    const Estimate albedo = t.out[0];
    report.row({text("%g", row.albedo), text("%g", row.distance), albedo.text(),
                row.known > 0 ? text("%.4f", row.known) : "-",
                row.known > 0 ? report.z(albedo, row.known, 3e-4) : "-"});
  }
}

}  // namespace

void print_analytic_bodies(Report& report) {
  print_slabs(report, 4000);
  print_spheres(report, 4100);
  print_chords(report, 4200);
  print_edges(report, 4300);
}

}  // namespace alabaster::testing
