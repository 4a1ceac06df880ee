// Henyey-Greenstein scattering: the sampler, the invariance of the mean path, and the white furnace. Albedos by g:
// testenv/walks/tables/anisotropy.cpp.
#include <gtest/gtest.h>

#include "testenv/support/analytic_bodies.h"
#include "testenv/support/chi_square.h"
#include "testenv/support/scene_builder.h"
#include "testenv/support/walk_pdfs.h"
#include "testenv/support/z_test.h"

namespace alabaster::testing {
namespace {

constexpr float kAsymmetries[] = {-0.9f, -0.5f, 0.0f, 0.3f, 0.7f, 0.9f};

std::optional<Vec3f> scatter(const Vec3f& direction, float g, Rng& rng) {
  return HenyeyGreensteinPhase(g).sample(direction, uniform2(rng));
}

ChiSquareResult test_phase(const Vec3f& direction, float g, float pdf_g, uint64_t seed) {
  ChiSquareOptions options{.bins_x = 20, .bins_y = 30, .samples = 100000, .seed = seed};
  options.frame = frame_from_normal(g < 0 ? -direction : direction);  // fine bins at the peak
  options.pole_exponent = 2;
  return chi_square_sphere([&](Rng& rng) { return scatter(direction, g, rng); },
                           [&](const Vec3f& w) { return pdf_henyey_greenstein(dot(direction, w), pdf_g); }, options);
}

TEST(HenyeyGreensteinChiSquare, DrawsFromItsPdf) {
  uint64_t seed = 200;
  for (const float g : kAsymmetries)
    for (const Vec3f& direction : {Vec3f(0, 0, 1), normalize(Vec3f(0.3f, -0.8f, -0.2f))}) {
      const ChiSquareResult result = test_phase(direction, g, g, ++seed);
      EXPECT_TRUE(plausible(result)) << g;
    }
}

TEST(HenyeyGreensteinChiSquare, AWrongPdfFails) {
  const Vec3f direction(0, 0, 1);
  EXPECT_TRUE(noticed(test_phase(direction, 0.5f, 0.52f, 1)));
  EXPECT_TRUE(noticed(test_phase(direction, 0.5f, -0.5f, 2)));
  EXPECT_TRUE(noticed(test_phase(direction, 0.9f, 0.895f, 3)));
  EXPECT_TRUE(noticed(test_phase(direction, 0.03f, 0.0f, 4)));
}

TEST(AnisotropicSphere, IsWhiteAndItsMeanPathDoesNotKnowG) {
  // Blanco and Fournier 2003: without absorption the mean path is 4V/S = 4/3 radius for any scattering inside.
  constexpr double kRadius = 2;
  uint64_t seed = 500;
  for (const float g : kAsymmetries) {
    Medium medium = unit_medium(0);
    medium.g = g;
    Rng rng(run_seed(++seed), 78);
    RenderCounters counters;
    RunningStatistics lengths, collisions;
    for (int i = 0; i < run_samples(40000); ++i) {
      SphereTracer tracer(kRadius);
      const auto end = walk_body(tracer, medium, {}, rng, counters);
      ASSERT_TRUE(end);
      ASSERT_EQ(end->throughput[0], 1);
      lengths.add(tracer.path_length());
      collisions.add(end->events);
    }
    for (const RunningStatistics& values : {lengths, collisions}) {
      const ZTestResult result = z_test(values, 4.0 / 3 * kRadius, {.slack = 1e-5});
      EXPECT_TRUE(plausible(result)) << g;
    }
  }
}

// Guiding and sphere steps rely on the diffusion modes of isotropic scattering, so walks with g != 0 take neither.
TEST(AnisotropicSphere, TakesNoShortcut) {
  const auto sphere_steps = [](float g) {
    const Medium medium = make_medium(Rgb(0.95f), Rgb(0.05f), AlbedoInversion::exact, g);
    RenderCounters counters;
    for (uint64_t i = 0; i < 200; ++i) {
      Rng rng(i, 79), plain_rng(i, 79);
      SphereTracer tracer(1), plain_tracer(1);
      const auto end = walk_body_with_shortcuts(tracer, medium, {}, rng, counters);
      const auto plain = walk_body(plain_tracer, medium, {}, plain_rng, counters);
      if (g == 0) continue;
      EXPECT_EQ(end.has_value() ? end->events : 0, plain.has_value() ? plain->events : 0);
    }
    return counters.walk_sphere_steps;
  };
  EXPECT_GT(sphere_steps(0), 0u);
  for (const float g : {-0.5f, 1e-3f, 0.7f}) EXPECT_EQ(sphere_steps(g), 0u);
}

RenderRequest sphere_picture(const DisneyParameters& parameters, double scale) {
  SceneBuilder b;
  b.add(b.prototype(sphere_mesh(static_cast<float>(scale), 48, false)), b.material(parameters));
  b.add(constant_dome(1, false));
  RenderRequest request;
  request.scene = b.snapshot();
  request.camera = look_at({0, 0, 4 * scale}, {0, 0, 0}, 4);
  request.width = request.height = 16;
  request.data_window = {0, 0, 16, 16};
  request.settings.samples = 64;
  return request;
}

// In the whole renderer, entry and exit lobes let 41/42 of a white body's light out again (F_V is zero at 8 degrees).
TEST(AnisotropicRender, WhiteBodyReturnsEverythingAtEveryG) {
  for (const float g : kAsymmetries) {
    DisneyParameters p;
    p.base_color = Rgb(1.0f);
    p.roughness = 0;  // no retro-reflection
    p.specular = 0;
    p.scatter_distance = Rgb(0.3f, 0.2f, 0.4f);
    p.scatter_anisotropy = g;
    RenderProgress progress;
    const MeanError m = film_mean(*render(sphere_picture(p, 1), &progress), 1);
    EXPECT_TRUE(plausible(z_test(m.mean, m.standard_error, 41.0 / 42, {.slack = 1e-6}))) << g;
    EXPECT_EQ(progress.counters.walk_safety_cap + progress.counters.walk_lost, 0u);
  }
}

}  // namespace
}  // namespace alabaster::testing
