// Light below the surface at the ends of albedo, distance, thickness, scale and place.
#include <limits>

#include "core/material/disney_bsdf.h"
#include "core/subsurface/dwivedi.h"
#include "testenv/extremes/rows.h"
#include "testenv/support/chi_square.h"
#include "testenv/support/half_space.h"
#include "testenv/support/transport_solution.h"
#include "testenv/walks/tables/walks.h"

namespace alabaster::testing {
namespace {

constexpr float kInfinite = std::numeric_limits<float>::infinity(), kNan = std::numeric_limits<float>::quiet_NaN();

double exact_complement(double albedo) {
  return one_minus_alpha(albedo, AlbedoInversion::exact);
}

// ---- albedo

void print_black(Rows& rows) {
  const double alpha = 1 - exact_complement(1e-6), paper = 1 - one_minus_alpha(1e-6, AlbedoInversion::chiang2016);
  rows.compare("inversion", "A = 1e-6", "alpha, exact", {alpha, 1e-12}, 4.888e-6, 1e-9, "digits of the answer");
  rows.compare("inversion", "A = 1e-6", "alpha, eq. 1", {paper, 1e-12}, 5.094e-6, 1e-9, "digits of the answer");
  const DwivediMode mode = dwivedi_mode(1);
  rows.require("guiding", "A = 0", "no guide: x = 0 or 1, finite", "exact", text("x = %g", double(mode.x)),
               std::isfinite(mode.x) && std::isfinite(mode.alpha));
  const WalkTotals t = walk_bodies([] { return SlabTracer(); }, unit_medium(exact_complement(0)), WalkSettings(),
                                   rows.report().walks_for(0.01), 100);
  rows.require("half-space", "A = 0", "nothing returns", "exact", text("%g", t.out[0].mean()), t.out[0].max() == 0);
}

void print_white(Rows& rows) {
  for (const double tau : {0.1, 3.0}) {
    const WalkTotals t = walk_bodies([&] { return SphereTracer(tau); }, unit_medium(0), plain_walk(),
                                     rows.report().walks_for(0.05), 110);
    rows.require("sphere", text("A = 1, radius %g mfp", tau), "all light leaves, each walk with weight 1", "exact",
                 text("mean %.12g, largest %.12g, cap met %g times", t.out[0].mean(), t.counters.max_walk_weight,
                      double(t.counters.walk_safety_cap)),
                 t.out[0].mean() == 1 && t.counters.max_walk_weight == 1 && t.counters.walk_safety_cap == 0);
  }
  WalkSettings steps;
  steps.guiding = false;
  const WalkTotals t =
      walk_bodies([] { return SlabTracer(); }, unit_medium(0), steps, rows.report().walks_for(0.05), 112);
  const auto cost = static_cast<double>(t.counters.walk_rays + t.counters.walk_sphere_steps);
  rows.compare("half-space with sphere steps", "A = 1", "rays and steps in a walk that is recurrent",
               {cost / static_cast<double>(t.counters.walks), 2 * t.events.standard_error()}, 17.4, 0.5,
               "the answer is another program's");
  rows.require("half-space with sphere steps", "A = 1", "every walk ends by itself, with weight 1",
               "float rounding of 1e-5", text("mean %.8g", t.out[0].mean()),
               std::abs(t.out[0].mean() - 1) < 1e-5 && t.counters.walk_exits == t.counters.walks);
}

void print_bad_albedos(Rows& rows) {
  const auto medium_of = [](float albedo) { return make_medium(Rgb(albedo), Rgb(1.0f), AlbedoInversion::exact); };
  const Medium white = medium_of(1), black = medium_of(0);
  const auto same = [](const Medium& a, const Medium& b) { return a.alpha == b.alpha && a.sigma_t == b.sigma_t; };
  rows.require("medium", "A = 2, infinity", "that of A = 1", "bits", text("alpha = %g", double(medium_of(2).alpha.g)),
               same(medium_of(2), white) && same(medium_of(kInfinite), white));
  rows.require("medium", "A = -1, -infinity, NaN", "that of A = 0", "bits",
               text("alpha = %g", double(medium_of(kNan).alpha.g)),
               same(medium_of(-1), black) && same(medium_of(-kInfinite), black) && same(medium_of(kNan), black));
}

// ---- distance

RenderRequest body_in_furnace(float albedo, float distance, uint32_t samples, uint32_t seed) {
  SceneBuilder b;
  b.add(b.prototype(sphere_mesh(1, 48, true)), b.material(medium_only(albedo, distance)));
  b.add(constant_dome(1, false));
  RenderRequest request = picture_of(&b, look_at({0, 0, 5}, {0, 0, 0}, 8), samples, 24);
  request.settings.seed = seed;
  return request;
}

// A body much larger than the mean free path shows its albedo, however small that is, down to rounding error and below.
// A walk begins a little below the surface; if this distance did not count as a path through the medium, light would be
// lost at 1e-5.
void print_small_distances(Rows& rows, uint32_t samples) {
  RenderRequest lambert = body_in_furnace(0.5f, 0, samples, 0);
  const Picture without(lambert);
  lambert.settings.subsurface = SubsurfaceMode::lambert;
  const size_t different = different_values(without, Picture(lambert));
  rows.require("sphere in a furnace", "d = 0", "the diffuse of 2015", "bits", text("%zu values differ", different),
               different == 0);
  uint32_t seed = 0;
  for (const float distance : {1e-4f, 1e-5f, 1e-6f, 1e-9f, 1e-12f, 1e-20f, 1e-40f}) {
    const Picture with(body_in_furnace(0.5f, distance, samples, ++seed));
    const Estimate d = difference(with, without);
    rows.compare("sphere in a furnace", text("d = %g radii", double(distance)), "that of d = 0",
                 {d.mean + without.mean.mean, d.sigma}, without.mean.mean);
    rows.report().require(with.sound, "small distances are sound");
  }
}

void print_large_distances(Rows& rows) {
  for (const float distance : {1e20f, 3e38f, kInfinite}) {
    const Medium medium = make_medium(Rgb(0.2f), Rgb(distance), AlbedoInversion::exact);
    const WalkTotals t =
        walk_bodies([] { return SphereTracer(1); }, medium, WalkSettings(), rows.report().walks_for(0.01), 120);
    rows.require("sphere", text("A = .2, d = %g radii", double(distance)), "all light crosses: white", "exact",
                 text("mean %.12g", t.out[0].mean()), t.out[0].mean() == 1);
  }
  constexpr double kTau = 1e-3;
  const double complement = exact_complement(0.2);
  const WalkTotals t = walk_bodies([] { return SphereTracer(kTau); }, unit_medium(complement), plain_walk(),
                                   rows.report().walks_for(0.25, 0.3), 121);
  const double expected = complement * 4 / 3 * kTau;
  const double sigma = std::sqrt(expected / static_cast<double>(t.out[0].count()));
  rows.compare("sphere", "A = .2, radius 1e-3 mfp", "share that is lost, (1 - alpha) sigma_t 4V/S",
               {1 - t.out[0].mean(), sigma}, expected, 2 * kTau * expected, "the second order");
}

void print_odd_parameters(Rows& rows) {
  int pictures = 0, unsound = 0;
  double largest = 0;
  for (const float albedo : {0.0f, 1e-30f, 1.0f, 2.0f, -1.0f, kNan})
    for (const float distance : {0.0f, 1e-40f, 1e-20f, 1e20f, 3e38f, kInfinite, kNan}) {
      RenderRequest request = body_in_furnace(albedo, distance, 2, 3);
      request.width = request.height = 8;
      request.data_window = {0, 0, 8, 8};
      const Picture picture(request);
      ++pictures;
      unsound += !picture.sound;
      largest = std::max(largest, picture.mean.mean - 4 * picture.mean.sigma);
    }
  rows.require("sphere in a furnace", "A and d at 0, tiny, huge, infinite, negative, NaN, each with each",
               "finite and no brighter than the furnace", "4 standard errors",
               text("%d of %d pictures unsound, brightest %.4f", unsound, pictures, largest),
               unsound == 0 && largest <= 1);
}

// ---- bodies with an answer

void print_spheres(Rows& rows, uint32_t seed) {
  for (const double tau : {0.1, 1.0, 3.0, 10.0}) {
    RunningStatistics uncollided;
    for (const double albedo : {0.2, 0.5, 0.8, 0.95}) {
      const SphereAnswer answer = solve_sphere(tau, exact_complement(albedo));
      const WalkTotals t = walk_bodies([&] { return SphereTracer(tau); }, unit_medium(exact_complement(albedo)),
                                       plain_walk(), rows.report().walks_for(0.1), ++seed);
      rows.compare("sphere in a furnace", text("radius %g mfp, A = %g", tau, albedo), "albedo, integral equation",
                   t.out[0], answer.albedo, answer.error, "quadrature");
      uncollided.merge(t.uncollided);
    }
    rows.compare("sphere", text("radius %g mfp", tau), "crosses without collision", uncollided,
                 sphere_zero_scatter(tau));
  }
}

void print_mean_paths(Rows& rows, uint32_t seed) {
  for (const double tau : {0.01, 1.0, 10.0, 30.0}) {
    const double chord = 4.0 / 3 * tau;
    const auto walk = [&](Rng& rng, RunningStatistics& lengths) {
      SphereTracer tracer(tau);
      RenderCounters counters;
      walk_body(tracer, unit_medium(0), plain_walk(), rng, counters);
      lengths.add(tracer.path_length() / chord);
    };
    const auto lengths = run_chunks<RunningStatistics>(rows.report().walks_for(0.1, tau > 1 ? 3 : 1), ++seed, walk);
    rows.compare("sphere", text("A = 1, radius %g mfp", tau), "mean path over 4V/S", lengths, 1);
  }
}

void print_slabs(Rows& rows, uint32_t seed) {
  for (const double albedo : {0.5, 0.9, 1.0})
    for (const double thickness : {1.0, 4.0, 10.0}) {
      const SlabAnswer answer = solve_slab(thickness, exact_complement(albedo));
      const WalkTotals t = walk_bodies([&] { return SlabTracer(thickness); }, unit_medium(exact_complement(albedo)),
                                       plain_walk(), rows.report().walks_for(0.1), ++seed);
      const std::string extreme = text("A = %g, %g mfp thick", albedo, thickness);
      rows.compare("slab", extreme, "reflectance, integral equation", t.back, answer.reflectance, answer.error,
                   "quadrature");
      rows.compare("slab", extreme, "transmittance", t.through, answer.transmittance, answer.error, "quadrature");
      if (albedo == 1) rows.report().require(t.out[0].mean() == 1, "R + T = 1");
    }
  for (const auto& [albedo, known] : {std::pair{0.8, .9243}, {0.95, .9928}}) {
    const WalkTotals t = walk_bodies([] { return EdgeTracer(1); }, unit_medium(exact_complement(albedo)), plain_walk(),
                                     rows.report().walks_for(0.08), ++seed);
    rows.compare("90 degree edge, 1 mfp from it", text("A = %g", albedo), "albedo", t.out[0], known, 3e-4,
                 "the answer is another program's");
  }
}

// Distances four decades apart: each channel must be that channel alone, and no product of transmittances may
// underflow.
void print_mixed_distances(Rows& rows, uint32_t seed) {
  const Rgb albedo(0.9f, 0.9f, 0.01f), distance(0.01f, 0.01f, 100.0f);
  const Medium medium = make_medium(albedo, distance, AlbedoInversion::exact);
  constexpr double kRadius = 0.05;
  const WalkTotals t =
      walk_bodies([] { return SphereTracer(kRadius); }, medium, plain_walk(), rows.report().walks_for(0.25), ++seed);
  for (const int c : {0, 2}) {
    const double complement = exact_complement(static_cast<double>(albedo[c]));
    const SphereAnswer answer = solve_sphere(kRadius * static_cast<double>(medium.sigma_t[c]), complement);
    rows.compare("sphere, A (.9, .9, .01), d (.01, .01, 100)", text("channel %d", c), "that channel alone", t.out[c],
                 answer.albedo, answer.error, "quadrature");
  }
  rows.require("the same", "largest throughput", "<= 3", "float rounding of 1e-6",
               text("%.7g", t.counters.max_walk_weight), t.counters.max_walk_weight <= 3 * (1 + 1e-6));
}

// ---- scale and place

// A set, overlapping shells, an open mesh and coarse smooth normals, all lengths times 2^k.
RenderRequest all_kinds_of_bodies(int exponent) {
  const double s = std::ldexp(1.0, exponent);
  const auto f = static_cast<float>(s);
  SceneBuilder b;
  const auto material = b.material(medium_only(0.9f, 0.3f * f));
  const auto at = [&](double x, double y) { return translation(x * s, y * s, 0); };
  const auto ball = b.prototype(sphere_mesh(f, 8, true));
  for (const double x : {-1.5, -0.5}) b.add(ball, material, at(x, 1));
  for (auto& instance : b.description.instances) instance.subsurface_set = "pair";
  b.add(b.prototype(
            merged(box_mesh({0, 0, 0}, Vec3f(1, 1, 1) * f), box_mesh(Vec3f(0.5f, 0.5f, 0.5f) * f, Vec3f(2, 1, 1) * f))),
        material, at(0.8, 0.2));
  b.add(b.prototype(plane_mesh(8 * f)), material, at(0, -1));
  LightParameters key;
  key.type = LightType::sphere;
  key.radius = 0.5f * f;
  key.intensity = 60;
  key.light_to_world = translation(-s, 4 * s, 3 * s);
  b.add(key);
  return picture_of(&b, look_at(Vec3d(0, 1, 6) * s, Vec3d(0, 0.5, 0) * s, 45), 2);
}

void print_powers_of_two(Rows& rows) {
  const Picture expected(all_kinds_of_bodies(0));
  size_t different = 0;
  for (int exponent = -20; exponent <= 20; exponent += 4)
    different += different_values(Picture(all_kinds_of_bodies(exponent)), expected);
  rows.require("a set, overlapping shells, an open mesh, coarse normals", "all lengths times 2^-20 to 2^20",
               "the same picture", "bits", text("%zu values differ", different), different == 0);
}

// A ball with a scatter distance of a thousandth, at the origin and far away. `other`: another object at the origin, so
// that the scene's centre is not near the ball.
RenderRequest small_distances_at(double offset, bool other, uint32_t seed) {
  SceneBuilder b;
  const auto ball = b.prototype(sphere_mesh(1, 48, true));
  b.add(ball, b.material(medium_only(0.8f, 1e-3f)), translation(offset, 0, 0));
  if (other) b.add(ball, b.material(medium_only(0.8f, 0)));
  LightParameters sun;
  sun.type = LightType::distant;
  sun.intensity = 3;
  sun.light_to_world = Matrix4d(0.8, 0, -0.6, 0, 0, 1, 0, 0, 0.6, 0, 0.8, 0, 0, 0, 0, 1);
  b.add(sun);
  RenderRequest request = picture_of(&b, look_at({offset, 0, 5}, {offset, 0, 0}, 12), 64, 24);
  request.settings.seed = seed;
  return request;
}

void print_far_away(Rows& rows) {
  const Picture here(small_distances_at(0, false, 0));
  for (const double offset : {1e6, 1e7}) {
    const size_t different = different_values(Picture(small_distances_at(offset, false, 0)), here);
    rows.require("ball with d of 1e-3 radii", text("at %g radii from the origin", offset), "the same picture", "bits",
                 text("%zu values differ", different), different == 0);
  }
  const Picture beside(small_distances_at(1e6, true, 2));
  const Estimate d = difference(beside, here);
  rows.compare("ball with d of 1e-3 radii", "at 1e6 radii from another one", "the mean of the picture at the origin",
               {d.mean + here.mean.mean, d.sigma}, here.mean.mean);
}

// ---- view and shape

void print_grazing_views(Rows& rows) {
  DisneyParameters skin;
  skin.scatter_distance = Rgb(1.0f);
  for (const float cosine : {1e-3f, 1e-6f, 1e-20f}) {
    const Vec3f wo(std::sqrt(1 - sqr(cosine)), 0, cosine);
    const float entry = DisneyBsdf(skin, wo).subsurface_entry().g;
    const double expected = 1 - 0.5 * std::pow(1 - double(cosine), 5);
    rows.require("entry into a body", text("cosine %g", double(cosine)), text("1 - .5 F_V = %.7g", expected),
                 "float rounding of 2e-7", text("%.7g", double(entry)), std::abs(double(entry) - expected) < 2e-7);
  }
}

// The 2015 model's retro-reflection: none at roughness 0, and more light than arrives at roughness 1.
void print_retro_reflection(Rows& rows) {
  DisneyParameters p = medium_only(1, 0);
  const auto furnace = [&](float roughness, EnergyModel energy) {
    p.roughness = roughness;
    const float cosine = 1e-3f;
    const DisneyBsdf bsdf(p, {std::sqrt(1 - sqr(cosine)), 0, cosine}, energy);
    Rng rng(17, 3);
    RunningStatistics light;
    for (uint64_t i = 0; i < rows.report().walks_for(0.1); ++i) {
      const auto s = bsdf.sample(rng.uniform(), uniform2(rng));
      light.add(s ? double(s->weight().g) : 0);
    }
    return Estimate(light);
  };
  rows.compare("white diffuse, cosine 1e-3", "roughness 0, burley2015", "(1 - .5 F_V) 41/42",
               furnace(0, EnergyModel::burley2015), (1 - 0.5 * std::pow(1 - 1e-3, 5)) * 41 / 42, 1e-6,
               "float rounding");
  rows.compare("white diffuse, cosine 1e-3", "roughness 1, burley2015", "the published model's, above 1",
               furnace(1, EnergyModel::burley2015), 1.5575, 0.01, "the limit is at cosine 0");
  rows.compare_most("white diffuse, cosine 1e-3", "roughness 1, bounded", "a furnace", furnace(1, EnergyModel::bounded),
                    1 + 1e-3);
}

void print_odd_bodies(Rows& rows) {
  const auto picture = [](Mesh mesh, uint32_t seed) {
    SceneBuilder b;
    b.add(b.prototype(std::move(mesh)), b.material(medium_only(0.8f, 0.3f))).add(constant_dome(1, false));
    RenderRequest request = picture_of(&b, look_at({3, 2, 4}, {0.5, 0.5, 0.5}, 12), 64);
    request.settings.seed = seed;
    return Picture(request);
  };
  const Mesh box = box_mesh({0, 0, 0}, {1, 1, 1});
  Mesh inverted = box;
  for (Corners& t : inverted.triangles) std::swap(t[1], t[2]);
  const Picture single = picture(box, 0);
  const auto same = [&](const char* extreme, const Picture& p) {
    const Estimate d = difference(p, single);
    rows.compare("box of 3 mfp in a furnace", extreme, "that of the sound box", {d.mean + single.mean.mean, d.sigma},
                 single.mean.mean);
    rows.report().require(p.sound && p.counters.walk_safety_cap == 0, "odd boxes are sound");
  };
  same("every face twice", picture(merged(box, box), 1));
  same("inside out", picture(inverted, 2));
  same("inside out and twice", picture(merged(inverted, box), 3));
  rows.require("box of 3 mfp in a furnace", "roulette, no cap", "the safety cap ends no walk", "exact",
               text("%g of %g walks", double(single.counters.walk_safety_cap), double(single.counters.walks)),
               single.counters.walk_safety_cap == 0 && single.counters.walk_lost == 0);
}

}  // namespace

void print_subsurface(Report& report) {
  Rows rows(
      report, "Light below the surface",
      "A: albedo. d: scatter distance. mfp: mean free path. Distances between four decades, and colours, have tables\n"
      "of their own in testenv/statistical/results/subsurface.md.");
  print_black(rows);
  print_white(rows);
  print_bad_albedos(rows);
  print_small_distances(rows, static_cast<uint32_t>(report.walks_for(0.0006)) / 8);
  print_large_distances(rows);
  print_odd_parameters(rows);
  print_spheres(rows, 8000);
  print_mean_paths(rows, 8100);
  print_slabs(rows, 8200);
  print_mixed_distances(rows, 8300);
  print_powers_of_two(rows);
  print_far_away(rows);
  print_grazing_views(rows);
  print_retro_reflection(rows);
  print_odd_bodies(rows);
}

}  // namespace alabaster::testing
