// The whole renderer, from camera to film, in white furnaces: thin slabs, spheres and an edge. Walks take the shortcuts
// of the default mode, except where collisions are counted.
#include "testenv/support/mesh_bodies.h"
#include "testenv/support/scene_builder.h"
#include "testenv/support/transport_solution.h"
#include "testenv/walks/tables/tables.h"
#include "testenv/walks/tables/walks.h"

namespace alabaster::testing {
namespace {

/// In uniform light the exit lobe (1/pi)(1 - .5 F_L) returns 1 - 1/42 (2 Int mu (1-mu)^5 dmu = 1/21); seen along the
/// normal the entry's 1 - .5 F_V is one.
constexpr double kExitLobe = 41.0 / 42;

/// The error allowed for sphere steps.
constexpr double kShortcutBias = 1e-4;

/// The 2015 diffuse without its retro-reflective term and without a specular lobe.
DisneyParameters scattering_only(double albedo, double mean_free_path) {
  DisneyParameters p;
  p.base_color = Rgb(static_cast<float>(albedo));
  p.scatter_distance = Rgb(static_cast<float>(mean_free_path / distance_scale(albedo)));
  p.roughness = 0;
  p.ior = 1;
  p.specular = 0;
  return p;
}

class Furnace {
 public:
  explicit Furnace(Report& report) : report_(report) {}

  SceneBuilder builder;

  /// The albedo of the visible body: the film's mean over the exit lobe's transmission.
  Estimate albedo(const CameraParameters& camera, uint32_t seed, double factor = 2,
                  SubsurfaceMode mode = SubsurfaceMode::walk) {
    constexpr int kSize = 64;
    builder.add(constant_dome(1, false));
    RenderRequest request;
    request.scene = builder.snapshot();
    request.camera = camera;
    request.width = request.height = kSize;
    request.data_window = {0, 0, kSize, kSize};
    request.settings.samples = static_cast<uint32_t>(1 + report_.walks_for(0.25, factor) / (kSize * kSize));
    request.settings.seed = seed;
    request.settings.subsurface = mode;
    request.settings.filter = PixelFilter::box;
    RenderProgress progress;
    const MeanError film = film_mean(*render(request, &progress), 1);
    counters = progress.counters;
    report_.require(counters.walk_lost == 0 && counters.walk_safety_cap == 0, "a render loses no walk");
    report_.require(counters.nonfinite_samples == 0, "every sample is finite");
    return {film.mean / kExitLobe, film.standard_error / kExitLobe};
  }

  RenderCounters counters;

 private:
  Report& report_;
};

/// From above onto the point (x, *, 0), all rays parallel, `size` wide.
CameraParameters from_above(double x, double size) {
  CameraParameters camera = look_at({x, 10, 0}, {x, 0, 0}, 30);
  camera.orthographic = true;
  camera.horizontal_aperture = camera.vertical_aperture = static_cast<float>(size);
  return camera;
}

/// A slab of thickness one and `depth` mean free paths; a black floor just below takes what comes through.
Estimate slab(Report& report, double albedo, double depth, bool floor, uint32_t seed) {
  Furnace furnace(report);
  const auto half = static_cast<float>(100 + 200 / depth);
  SceneBuilder& b = furnace.builder;
  b.add(b.prototype(box_mesh({half, 0.5f, half})), b.material(scattering_only(albedo, 1 / depth)));
  if (floor)
    b.add(b.prototype(plane_mesh(2 * half)), b.material(scattering_only(0, 0)),
          Matrix4d().setTranslation(Vec3d(0, -0.51, 0)));
  return furnace.albedo(from_above(0, 0.01), seed);
}

void print_slabs(Report& report, uint32_t seed) {
  report.heading("Rendered: thin slabs");
  report.paragraph(
      "A wide closed box in a white furnace, seen from above: R with a black floor below, R + T without. At A = 0\n"
      "only light without collisions crosses. Values are divided by the exit lobe's 41/42.");
  report.columns({"A", "L", "R", "theory", "z", "R + T", "theory", "z"});
  for (const double albedo : {0.0, 0.5, 0.9, 1.0})
    for (const double depth : {1.0, 4.0, 10.0}) {
      if (albedo == 0 && depth > 4) continue;  // 7e-6 of the light, too little to measure here
      const SlabAnswer answer = solve_slab(depth, one_minus_alpha(albedo, AlbedoInversion::exact));
      const double both = answer.reflectance + answer.transmittance;
      const Estimate back = slab(report, albedo, depth, true, ++seed), all = slab(report, albedo, depth, false, ++seed);
      const double slack = answer.error + kShortcutBias;
      report.row({text("%g", albedo), text("%g", depth), back.text(), text("%.6f", answer.reflectance),
                  report.z(back, answer.reflectance, slack), all.text(), text("%.6f", both),
                  report.z(all, both, 2 * slack)});
    }
}

void print_spheres(Report& report, uint32_t seed) {
  constexpr int kRings = 128;
  report.heading("Rendered: spheres");
  report.paragraph(
      "Radius of tau mean free paths, 128 rings, the middle seen from afar. The tessellation may err by 3e-4.");
  report.columns({"tau", "A", "albedo", "theory", "z"});
  const auto mesh = SceneBuilder().prototype(sphere_mesh(1, kRings, false));
  for (const double tau : {0.1, 1.0, 3.0, 10.0})
    for (const double albedo : {0.2, 0.5, 0.8, 0.95}) {
      const SphereAnswer answer = solve_sphere(tau, one_minus_alpha(albedo, AlbedoInversion::exact));
      Furnace furnace(report);
      furnace.builder.add(mesh, furnace.builder.material(scattering_only(albedo, 1 / tau)));
      const Estimate measured = furnace.albedo(look_at({0, 0, 4}, {0, 0, 0}, 4), ++seed);
      report.row(
          {text("%g", tau), text("%g", albedo), measured.text(), text("%.5f", answer.albedo),
           report.z(measured, answer.albedo, answer.error + kShortcutBias + 2 * std::pow(M_PI / (2 * kRings), 2))});
    }
}

void print_edge(Report& report, uint32_t seed) {
  report.heading("Rendered: 90-degree edge");
  report.paragraph("One mean free path from the edge of a box 800 wide, compared with the loop in a quarter space.");
  report.columns({"A", "rendered", "quarter space", "z"});
  for (const double albedo : {0.8, 0.95}) {
    Furnace furnace(report);
    SceneBuilder& b = furnace.builder;
    b.add(b.prototype(box_mesh({400, 400, 400})), b.material(scattering_only(albedo, 1)));
    CameraParameters camera = from_above(-399, 0.01);
    camera.camera_to_world = camera.camera_to_world * Matrix4d().setTranslation(Vec3d(0, 600, 0));
    const Estimate rendered = furnace.albedo(camera, ++seed);
    const WalkTotals lab =
        walk_bodies([] { return EdgeTracer(1); }, unit_medium(one_minus_alpha(albedo, AlbedoInversion::exact)),
                    plain_walk(), report.walks_for(0.08), ++seed);
    report.row(
        {text("%g", albedo), rendered.text(), Estimate(lab.out[0]).text(), report.z_between(rendered, lab.out[0])});
  }
}

void print_collisions(Report& report, uint32_t seed) {
  constexpr int kRenders = 16;
  report.heading("Rendered: collisions in a white sphere");
  report.paragraph(
      "Events per walk over sigma_t 4 V / S, from the counters of 16 renders each. Every point of the visible\n"
      "sphere is equivalent.");
  report.columns({"tau", "collisions", "z", "albedo", "z"});
  const auto mesh = SceneBuilder().prototype(sphere_mesh(1, 128, false));
  for (const double tau : {0.1, 1.0, 10.0}) {
    RunningStatistics ratios, albedos;
    for (int i = 0; i < kRenders; ++i) {
      Furnace furnace(report);
      furnace.builder.add(mesh, furnace.builder.material(scattering_only(1, 1 / tau)));
      albedos.add(furnace.albedo(look_at({0, 0, 4}, {0, 0, 0}, 4), ++seed, 6, SubsurfaceMode::reference).mean);
      ratios.add(static_cast<double>(furnace.counters.walk_events) / static_cast<double>(furnace.counters.walks) /
                 (4.0 / 3 * tau));
    }
    report.row({text("%g", tau), Estimate(ratios).text(), report.z(ratios, 1, 2e-4), Estimate(albedos).text(),
                report.z(albedos, 1)});
  }
}

}  // namespace

void print_rendered_bodies(Report& report) {
  print_slabs(report, 6000);
  print_spheres(report, 6100);
  print_edge(report, 6200);
  print_collisions(report, 6300);
}

}  // namespace alabaster::testing
