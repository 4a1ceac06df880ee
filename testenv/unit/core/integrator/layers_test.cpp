// Layers over light that comes from below a surface, and on the backs of sheets.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "testenv/support/path_tracer.h"
#include "testenv/support/z_test.h"

namespace alabaster {
namespace {

using testing::PathTracer;
using testing::RunningStatistics;
using testing::SceneBuilder;

Vec3d towards(double degrees, double azimuth) {
  const double theta = degrees * M_PI / 180;
  return {std::sin(theta) * std::cos(azimuth), std::cos(theta), std::sin(theta) * std::sin(azimuth)};
}

LightParameters distant(const Vec3d& from) {
  LightParameters light;
  light.type = LightType::distant;
  light.angle = 0;
  const Vec3d z = normalize(from), x = normalize(cross(Vec3d(0.1, 0.2, 1), z)), y = cross(z, x);
  for (int i = 0; i < 3; ++i)
    light.light_to_world[0][i] = x[i], light.light_to_world[1][i] = y[i], light.light_to_world[2][i] = z[i];
  return light;
}

struct Setup {
  DisneyParameters material;
  double light = 20, eye = 65;  // degrees
};

/// Radiance over irradiance of a plane that fills the view.
RunningStatistics reflectance(const Setup& s, SubsurfaceMode mode, bool twins, int samples) {
  SceneBuilder b;
  b.add(b.prototype(testing::plane_mesh(200)), b.material(s.material)).add(distant(towards(s.light, 0.4)));
  PathTracer tracer(b.snapshot(), towards(s.eye, 2) * 5.0);
  tracer.settings.subsurface = mode;
  tracer.settings.walk.twins = twins;
  tracer.settings.max_depth = 4;
  RunningStatistics statistics;
  const double cosine = std::cos(s.light * M_PI / 180);
  for (int i = 0; i < testing::run_samples(samples); ++i)
    statistics.add(double(tracer.trace(static_cast<uint32_t>(i)).color.r) / cosine);
  return statistics;
}

DisneyParameters skin(float coat, float sheen, float layer_roughness) {
  DisneyParameters p = testing::matt({0.9f, 0.5f, 0.2f});
  p.scatter_distance = Rgb(0.05f);
  p.coat = coat;
  p.coat_roughness = layer_roughness;
  p.sheen = sheen;
  p.sheen_roughness = layer_roughness;
  p.sheen_color = {0.7f, 0.4f, 0.9f};
  return p;
}

// A half-space whose light comes out near where it entered is Lambert's under the same layers, which is reciprocal.
void expect_lambert(const DisneyParameters& material) {
  for (const auto& [light, eye] : {std::pair(20.0, 65.0), std::pair(65.0, 20.0)}) {
    const Setup setup{material, light, eye};
    const double lambert = reflectance(setup, SubsurfaceMode::lambert, false, 1).mean();
    const auto expect = [&](SubsurfaceMode mode, bool twins, int samples, const char* what) {
      const auto result = z_test(reflectance(setup, mode, twins, samples), lambert, {.slack = 4e-3 * lambert});
      EXPECT_TRUE(plausible(result)) << what << " " << light;
    };
    expect(SubsurfaceMode::walk, true, 50, "walk");
    expect(SubsurfaceMode::walk, false, 8000, "reference");
    expect(SubsurfaceMode::diffusion, false, 8000, "diffusion");
  }
}

TEST(LayersOverSubsurface, ACoatedHalfSpaceIsLambertUnderTheCoat) {
  expect_lambert(skin(1, 0, 0.3f));
  expect_lambert(skin(0.5f, 0, 0.8f));
}

TEST(LayersOverSubsurface, AStainedHalfSpaceIsLambertUnderTheStain) {
  DisneyParameters p = skin(0.8f, 0.3f, 0.3f);
  p.coat_ior = 1.9f, p.coat_color = Rgb(0.3f), p.coat_darkening = 0.7f;
  expect_lambert(p);
}

TEST(LayersOverSubsurface, AFibrousHalfSpaceIsLambertUnderTheFibres) {
  expect_lambert(skin(0, 1, 0.5f));
  expect_lambert(skin(0.6f, 0.7f, 0.2f));
}

TEST(LayersOverSubsurface, AWhiteHalfSpaceInAFurnaceSendsBackWhatLambertsTermDoes) {
  for (const bool coated : {true, false})
    for (const float roughness : {0.2f, 0.6f})
      for (const double eye : {0.0, 50.0, 80.0}) {
        SceneBuilder b;
        DisneyParameters p = skin(coated ? 1 : 0, coated ? 0 : 1, roughness);
        p.base_color = p.sheen_color = Rgb(1.0f);
        b.add(b.prototype(testing::plane_mesh(200)), b.material(p)).add(testing::constant_dome(1, true));
        PathTracer tracer(b.snapshot(), towards(eye, 1) * 5.0);
        const auto shown = [&](SubsurfaceMode mode, uint32_t samples) {
          tracer.settings.subsurface = mode;
          RunningStatistics statistics;
          for (uint32_t i = 0; i < testing::run_samples(samples); ++i) statistics.add(double(tracer.trace(i).color.g));
          return statistics;
        };
        const auto walk = shown(SubsurfaceMode::walk, 400), lambert = shown(SubsurfaceMode::lambert, 4000);
        EXPECT_TRUE(plausible(testing::at_most_test(walk, 1.003))) << coated << roughness << " at " << eye;
        EXPECT_TRUE(plausible(z_test(walk, lambert, {.slack = 0.01}))) << coated << roughness << " at " << eye;
      }
}

/// The light of a white sky that the back of an open plane shows.
RunningStatistics back_of(DisneyParameters p, float diff_trans, float spec_trans) {
  p.diff_trans = diff_trans;
  p.spec_trans = spec_trans;
  SceneBuilder b;
  b.add(b.prototype(testing::plane_mesh(200)), b.material(p)).add(testing::constant_dome(1, true));
  PathTracer tracer(b.snapshot(), towards(60, 1) * -5.0);
  RunningStatistics shown;
  for (uint32_t i = 0; i < testing::run_samples(8000u); ++i) shown.add(double(tracer.trace(i).color.b));
  return shown;
}

TEST(LayersOnSheets, ATraceOfTransmissionLeavesTheLayersOnTheBackOfAnOpenMesh) {
  DisneyParameters plain;
  plain.base_color = {0.6f, 0.4f, 0.2f};
  plain.roughness = 0.3f;
  DisneyParameters layered[4] = {plain, plain, plain, plain};
  layered[0].coat = 1, layered[0].coat_roughness = 0.2f;
  layered[1].sheen = 1, layered[1].sheen_roughness = 0.4f;
  layered[2].clearcoat = 1;
  layered[3].metallic = 0.5f, layered[3].iridescence = 1;
  const double bare = back_of(plain, 0, 0).mean();
  for (const DisneyParameters& p : layered) {
    const auto opaque = back_of(p, 0, 0);
    EXPECT_GT(std::abs(opaque.mean() - bare), 0.004) << "else this test would see nothing";
    for (const float trace : {1e-4f, 1e-2f})
      for (const bool clear : {false, true}) {
        const auto seen = back_of(p, clear ? 0 : trace, clear ? trace : 0);
        EXPECT_TRUE(plausible(z_test(seen, opaque, {.slack = trace}))) << trace << clear;
      }
  }
}

}  // namespace
}  // namespace alabaster
