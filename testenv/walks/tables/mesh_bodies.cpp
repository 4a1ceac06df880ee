// RandomWalk itself on triangle meshes through Embree: shares, lengths and exits of walks.
#include "testenv/support/lone_body.h"
#include "testenv/support/transport_solution.h"
#include "testenv/walks/tables/tables.h"
#include "testenv/walks/tables/walks.h"

namespace alabaster::testing {
namespace {

struct Body : BodyInWorld {
  SurfaceSampler surface;

  explicit Body(const Mesh& mesh) : BodyInWorld(mesh), surface(mesh) {}
};

struct MeshTotals {
  RunningStatistics out, collisions, crossing, uncollided;
  RunningStatistics top, bottom, sides;  // shares that left there, for a box
  RenderCounters counters;

  void merge(const MeshTotals& o) {
    out.merge(o.out);
    collisions.merge(o.collisions);
    crossing.merge(o.crossing);
    uncollided.merge(o.uncollided);
    top.merge(o.top);
    bottom.merge(o.bottom);
    sides.merge(o.sides);
    counters.add(o.counters);
  }
};

/// `where(rng)` says where a walk enters.
template <class Where>
MeshTotals walk_mesh(const Body& body, const Medium& medium, uint64_t walks, uint32_t seed, const Where& where) {
  const WalkMedium walk_medium = medium;
  const RandomWalk walk{plain_walk()};
  return run_chunks<MeshTotals>(walks, seed, [&](Rng& rng, MeshTotals& totals) {
    const uint64_t before = totals.counters.walk_events;
    const auto exit = carry(walk, body.body(), body.entry(where(rng), walk_medium), rng, totals.counters);
    const double weight = exit ? static_cast<double>(exit->throughput.r) : 0;
    totals.out.add(weight);
    totals.collisions.add(static_cast<double>(totals.counters.walk_events - before));
    totals.uncollided.add(exit && exit->events == 0 ? weight : 0);
    if (exit && exit->events == 0) totals.crossing.add(static_cast<double>(exit->hit.t));
    totals.top.add(exit && exit->hit.triangle < 2 ? weight : 0);
    totals.bottom.add(exit && exit->hit.triangle >= 2 && exit->hit.triangle < 4 ? weight : 0);
    totals.sides.add(exit && exit->hit.triangle >= 4 ? weight : 0);
  });
}

auto anywhere(const Body& body) {
  return [&body](Rng& rng) {
    const float a = rng.uniform(), b = rng.uniform();
    return body.surface.sample({a, b, rng.uniform()});
  };
}

/// The top of a box at the point (x, 0, 0): on triangle 0 = (-x,+y,-z), (-x,+y,+z), (+x,+y,+z) or on its diagonal.
auto on_top(const Vec3f& half, float x) {
  return [half, x](Rng&) {
    TriangleHit hit;
    // p = p0 + u (p1 - p0) + v (p2 - p0) with p1 - p0 = (0,0,2hz), p2 - p0 = (2hx,0,2hz).
    hit.v = 0.5f * (1 + x / half.x);
    hit.u = 0.5f - hit.v;
    return hit;
  };
}

void require_nothing_lost(Report& report, const MeshTotals& t, const char* where) {
  report.require(t.counters.walk_lost == 0, text("no walk leaves a closed mesh unseen (%s)", where));
  report.require(t.counters.walk_safety_cap == 0, text("no walk meets the safety cap (%s)", where));
}

void print_slabs(Report& report, uint32_t seed) {
  report.heading("Meshes: a thin slab as a box");
  report.paragraph(
      "A closed box of twelve triangles, L mean free paths thick and 200 L + 400 wide. Walks enter in the middle of\n"
      "the top. Theory as for the thin slabs above.");
  report.columns({"A", "L", "R", "theory", "z", "T", "theory", "z", "no collision", "2 E3(L)", "z", "sides"});
  for (const double albedo : {0.5, 0.9, 1.0})
    for (const float thickness : {1.0f, 4.0f, 10.0f}) {
      const Vec3f half(100 * thickness + 200, 0.5f * thickness, 100 * thickness + 200);
      const Body box(box_mesh(half));
      const double complement = one_minus_alpha(albedo, AlbedoInversion::exact);
      const auto l = static_cast<double>(thickness);
      const SlabAnswer answer = solve_slab(l, complement);
      const MeshTotals t = walk_mesh(box, unit_medium(complement), report.walks_for(0.25), ++seed, on_top(half, 0));
      require_nothing_lost(report, t, "slab");
      report.row({text("%g", albedo), text("%g", l), Estimate(t.top).text(), text("%.6f", answer.reflectance),
                  report.z_share(t.top, answer.reflectance, answer.error), Estimate(t.bottom).text(),
                  text("%.6f", answer.transmittance), report.z_share(t.bottom, answer.transmittance, answer.error),
                  Estimate(t.uncollided).text(), text("%.6f", slab_zero_scatter(l)),
                  report.z_share(t.uncollided, slab_zero_scatter(l)), text("%g", t.sides.mean())});
      if (albedo == 1) report.require(t.counters.walk_exits == t.counters.walks, "R + T = 1 on a mesh");
    }
}

void print_spheres(Report& report, uint32_t seed) {
  report.heading("Meshes: spheres in uniform surroundings");
  // Volume and area of the inscribed polyhedron are smaller than the sphere's by about (pi / 2 rings)^2 and half of
  // that.
  constexpr int kRings = 256;
  const double slack = 2 * std::pow(M_PI / (2 * kRings), 2);
  report.paragraph(
      "Latitude-longitude spheres of 256 rings, 261 120 triangles. Walks enter anywhere on the surface. Theory is\n"
      "that of the true sphere; the polyhedron's difference of less than 8e-5 is tolerated.");
  report.columns({"tau", "A", "out", "theory", "z", "no collision", "theory", "z"});
  for (const double radius : {0.1, 1.0, 3.0, 10.0})
    for (const double albedo : {0.5, 0.8, 0.95}) {
      const Body sphere(sphere_mesh(static_cast<float>(radius), kRings, false));
      const double complement = one_minus_alpha(albedo, AlbedoInversion::exact);
      const SphereAnswer answer = solve_sphere(radius, complement);
      const uint64_t walks = report.walks_for(0.25, 1.5);
      const MeshTotals t = walk_mesh(sphere, unit_medium(complement), walks, ++seed, anywhere(sphere));
      require_nothing_lost(report, t, "sphere");
      report.row({text("%g", radius), text("%g", albedo), Estimate(t.out).text(), text("%.5f", answer.albedo),
                  report.z_share(t.out, answer.albedo, answer.error + slack), Estimate(t.uncollided).text(),
                  text("%.6f", sphere_zero_scatter(radius)),
                  report.z_share(t.uncollided, sphere_zero_scatter(radius), slack)});
    }
}

void print_chords(Report& report, uint32_t seed) {
  struct Shape {
    const char* name;
    Mesh mesh;
  };
  Shape shapes[] = {{"box 2 x 1 x 0.4", box_mesh({1.0f, 0.5f, 0.2f})},
                    {"sphere, 24 rings", sphere_mesh(1, 24, false)},
                    {"torus 1, 0.3 (not convex)", torus_mesh(1, 0.3f, 96)}};
  report.heading("Meshes: mean path inside a body that absorbs nothing");
  report.paragraph(
      "4 V / S of the triangles, for any mean free path (Blanco and Fournier 2003). `chord`: measured length of\n"
      "walks without scatterers (sigma_t = 0), followed by collisions over sigma_t 4 V / S.");
  report.columns({"mesh", "4 V / S", "chord", "z", "sigma_t 4V/S = .1", "z", "1", "z", "10", "z"});
  for (Shape& shape : shapes) {
    const double chord = 4 * mesh_volume(shape.mesh) / mesh_area(shape.mesh);
    const Body body(shape.mesh);
    std::vector<std::string> cells = {shape.name, text("%.6f", chord)};
    Medium medium = unit_medium(0);
    medium.sigma_t.r = 0;
    const MeshTotals clear = walk_mesh(body, medium, report.walks_for(0.25), ++seed, anywhere(body));
    require_nothing_lost(report, clear, shape.name);
    cells.push_back(Estimate(clear.crossing).text());
    cells.push_back(report.z(clear.crossing, chord, 1e-6 * chord));
    for (const double collisions : {0.1, 1.0, 10.0}) {
      medium.sigma_t.r = static_cast<float>(collisions / chord);
      const uint64_t walks = report.walks_for(0.25, collisions > 1 ? 2 : 1);
      const MeshTotals t = walk_mesh(body, medium, walks, ++seed, anywhere(body));
      require_nothing_lost(report, t, shape.name);
      report.require(t.counters.walk_exits == t.counters.walks, "a white body returns all light");
      const Estimate ratio(t.collisions.mean() / collisions, t.collisions.standard_error() / collisions);
      cells.push_back(ratio.text());
      cells.push_back(report.z(ratio, 1, 1e-6));
    }
    report.row(cells);
  }
}

void print_edges(Report& report, uint32_t seed) {
  report.heading("Meshes: 90-degree edge");
  report.paragraph("The edge of a box 800 mean free paths wide, compared with the loop in a quarter space.");
  report.columns({"A", "distance", "mesh", "quarter space", "z"});
  const Vec3f half(400, 400, 400);
  const Body box(box_mesh(half));
  for (const double albedo : {0.8, 0.95})
    for (const float distance : {0.25f, 1.0f, 4.0f}) {
      const Medium medium = unit_medium(one_minus_alpha(albedo, AlbedoInversion::exact));
      const uint64_t walks = report.walks_for(0.08);
      const MeshTotals mesh = walk_mesh(box, medium, walks, ++seed, on_top(half, distance - half.x));
      const WalkTotals lab =
          walk_bodies([&] { return EdgeTracer(static_cast<double>(distance)); }, medium, plain_walk(), walks, ++seed);
      require_nothing_lost(report, mesh, "edge");
      report.row({text("%g", albedo), text("%g", static_cast<double>(distance)), Estimate(mesh.out).text(),
                  Estimate(lab.out[0]).text(), report.z_between(mesh.out, lab.out[0])});
    }
}

}  // namespace

void print_mesh_bodies(Report& report) {
  print_slabs(report, 5000);
  print_spheres(report, 5100);
  print_chords(report, 5200);
  print_edges(report, 5300);
}

}  // namespace alabaster::testing
