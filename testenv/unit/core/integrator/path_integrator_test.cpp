#include "core/integrator/path_integrator.h"

#include <gtest/gtest.h>

#include <cmath>

#include "testenv/support/path_tracer.h"
#include "testenv/support/z_test.h"

namespace alabaster {
namespace {

using testing::matt;
using testing::PathTracer;
using testing::RunningStatistics;
using testing::SceneBuilder;

// Independent estimates: runs of 2^k aligned indices are stratified, so their means vary less than single samples do.
RunningStatistics means_of_green(PathTracer* tracer, int runs, int samples) {
  RunningStatistics statistics;
  uint32_t index = 0;
  for (int r = 0; r < testing::run_samples(runs); ++r) {
    double sum = 0;
    for (int i = 0; i < samples; ++i) sum += tracer->trace(index++).color.g;
    statistics.add(sum / samples);
  }
  return statistics;
}

// A convex matt body under a white sky shows its albedo, c (1 - .5 F_V) (1 - 1/42).
TEST(PathIntegrator, AConvexBodyInAFurnaceShowsItsAlbedo) {
  for (const double degrees : {0.0, 50.0, 80.0}) {
    const double theta = degrees * M_PI / 180;
    SceneBuilder b;
    b.add(b.prototype(testing::plane_mesh(2)), b.material(matt(Rgb(0.7f)))).add(testing::constant_dome(1, false));
    PathTracer tracer(b.snapshot(), {3 * std::sin(theta), 3 * std::cos(theta), 0});
    const double albedo = 0.7 * (1 - 0.5 * std::pow(1 - std::cos(theta), 5)) * 41 / 42;
    const auto result = z_test(means_of_green(&tracer, 256, 16), albedo, {.slack = 1e-5 * albedo});
    EXPECT_TRUE(plausible(result)) << degrees;
  }
}

// Inside a matt sphere that glows with E, the exitance kernel is constant and a chord meets both ends at the same
// angle, of cosine m. So L(m) = E + c T(m) A, T = 1 - .5 (1 - m)^5, and the mean A = 2 Int T L m dm over [0, 1] is
// E (41/42) / (1 - c (1 - 1/21 + 1/264)). Roulette must not change it.
TEST(PathIntegrator, RouletteKeepsTheRadianceInsideAGlowingSphere) {
  constexpr float kAlbedo = 0.7f, kEmission = 0.5f;
  SceneBuilder b;
  DisneyParameters wall = matt(Rgb(kAlbedo));
  wall.emission = Rgb(kEmission);
  b.add(b.prototype(testing::sphere_mesh(1, 48, false)), b.material(wall));
  const double mean = kEmission * (41.0 / 42) / (1 - kAlbedo * (1 - 1.0 / 21 + 1.0 / 264));
  const double expected = kEmission + kAlbedo * mean;  // seen head on
  PathTracer tracer(b.snapshot(), {0, 0, 0.5});
  tracer.settings.max_depth = 48;  // 0.7^48 = 4e-8
  // Facets of 1/48 of a half turn lie up to 1e-3 of the radius inside the sphere.
  const auto result = z_test(means_of_green(&tracer, 512, 16), expected, {.slack = 2e-3 * expected});
  EXPECT_TRUE(plausible(result));
  EXPECT_LT(tracer.counters.bounce_rays, 512u * 16 * 48 / 3) << "roulette ended paths";
}

// All lights are sampled, one of few is chosen, or one of many by a tree.
TEST(PathIntegrator, DimLightsBesideAConstantDomeAddNoNoise) {
  DisneyParameters skin;
  skin.base_color = Rgb(0.8f);
  skin.scatter_distance = Rgb(0.1f);
  for (const DisneyParameters& p : {matt(Rgb(0.7f)), skin}) {
    const auto variance = [&](int dim_lights) {
      SceneBuilder b;
      b.add(b.prototype(testing::sphere_mesh(1, 24, true)), b.material(p)).add(testing::constant_dome(1, false));
      LightParameters dim;
      dim.type = LightType::sphere;
      dim.intensity = 1e-6f;
      for (int i = 0; i < dim_lights; ++i) {
        dim.light_to_world = Matrix4d().setTranslation(Vec3d(3, 0.1 * i, 0));
        b.add(dim);
      }
      PathTracer tracer(b.snapshot(), {0, 3, 0});
      return means_of_green(&tracer, 2000, 1).variance();
    };
    const double alone = variance(0);
    for (const int dim_lights : {3, 4, 200})
      EXPECT_LT(variance(dim_lights), 1.2 * alone) << dim_lights << (p.scatters() ? ", skin" : "");
  }
}

TEST(PathIntegrator, APathBecomesTwoAtTheFirstSurface) {
  SceneBuilder b;
  b.add(b.prototype(testing::plane_mesh(20)), b.material(matt(Rgb(0.7f)))).add(testing::constant_dome(1, false));
  PathTracer tracer(b.snapshot(), {0, 4, 4});
  for (uint32_t i = 0; i < 8; ++i) tracer.trace(i);
  EXPECT_EQ(tracer.counters.camera_rays, 8u);
  EXPECT_EQ(tracer.counters.bounce_rays, 16u);
}

// A plane two units below the camera, by hand.
TEST(PathIntegrator, FirstHitValuesAreComputedForBoundAovsOnly) {
  SceneBuilder b;
  DisneyParameters plastic;
  plastic.base_color = {0.5f, 0.25f, 0.125f};
  b.add(b.prototype(testing::sphere_mesh(1e-3f, 4, false)), b.material({}), Matrix4d().setTranslation(Vec3d(1, -1, 0)));
  b.add(b.prototype(testing::plane_mesh(4)), b.material(plastic)).add(testing::constant_dome(1, false));
  PathTracer tracer(b.snapshot(), {0, 2, 0});
  const FilmSample unset;
  const Rgb color = tracer.trace(0).color;
  EXPECT_GT(color.r, 0);
  for (const AovInfo& info : kAovs) {
    tracer.aovs = aov_bit(info.aov);
    const char* name = info.name;
    const bool normal = tracer.aovs & aov_bit(Aov::normal), albedo = tracer.aovs & aov_bit(Aov::albedo);
    const bool closest = tracer.aovs & kClosestAovs;
    const FilmSample s = tracer.trace(0);
    EXPECT_EQ(s.color, color) << name;
    EXPECT_EQ(s.alpha, 1) << name;
    EXPECT_EQ(s.normal, normal ? Vec3f(0, 1, 0) : unset.normal) << name;
    EXPECT_NEAR(s.albedo.g, albedo ? 0.29f : 0, 1e-6f) << name << ": base color and f0";
    EXPECT_NEAR(s.camera_depth, closest ? 2.0f : unset.camera_depth, 1e-5f) << name;
    EXPECT_EQ(s.prim_id, closest || info.source == AovSource::ids ? 1 : unset.prim_id) << name;
    EXPECT_EQ(s.instance_id, closest ? 0 : unset.instance_id) << name;
    EXPECT_EQ(s.element_id >= 0, closest) << name;
    EXPECT_EQ(std::isfinite(s.distance), closest) << name;
  }
}

// The camera looks down at a floor; a green ceiling with a normal of its own hangs above it, or nothing does.
FilmSample guides_of_floor(const DisneyParameters& floor, bool has_ceiling) {
  SceneBuilder b;
  DisneyParameters green;
  green.base_color = {0.125f, 0.5f, 0.25f};
  b.add(b.prototype(testing::plane_mesh(4)), b.material(floor)).add(testing::constant_dome(1, false));
  if (has_ceiling)
    b.add(b.prototype(testing::plane_mesh(4)), b.material(green), Matrix4d().setTranslation(Vec3d(0, 3, 0)));
  PathTracer tracer(b.snapshot(), {0, 2, 0});
  tracer.aovs = kGuideAovs;
  return tracer.trace(0);
}

// promise: pipeline.aov.guides
TEST(PathIntegrator, GuidesShowWhatAMirrorShows) {
  DisneyParameters mirror;
  mirror.metallic = 1;
  mirror.roughness = 0;
  mirror.base_color = {0.5f, 0.5f, 1};
  FilmSample s = guides_of_floor(mirror, true);
  EXPECT_EQ(s.normal, Vec3f(0, -1, 0));
  EXPECT_NEAR(s.albedo.r, 0.5f * (0.125f + 0.04f), 2e-3f) << "base color and f0, tinted by the mirror";
  EXPECT_NEAR(s.albedo.g, 0.5f * (0.5f + 0.04f), 2e-3f);
  EXPECT_NEAR(s.albedo.b, 0.25f + 0.04f, 2e-3f);

  s = guides_of_floor(mirror, false);
  EXPECT_EQ(s.normal, Vec3f(0, 1, 0)) << "a mirror of nothing shows itself";
  EXPECT_NEAR(s.albedo.g, 0.5f, 0.05f);

  mirror.roughness = 0.4f;
  s = guides_of_floor(mirror, true);
  EXPECT_EQ(s.normal, Vec3f(0, 1, 0)) << "a rough metal is a surface";
}

/// The share of the samples of a shiny floor whose features are those of the ceiling that it mirrors.
RunningStatistics mirrored_features(bool in_mirror) {
  SceneBuilder b;
  DisneyParameters shiny, mirror;
  shiny.base_color = Rgb(0.1f);
  shiny.roughness = 0;
  mirror.metallic = 1;
  mirror.roughness = 0;
  mirror.base_color = Rgb(1.0f);
  const auto quad = b.prototype(testing::plane_mesh(4));
  b.add(quad, b.material(shiny)).add(testing::constant_dome(1, false));
  b.add(quad, b.material(matt(Rgb(0.5f))), Matrix4d().setTranslation(Vec3d(-6, 3, 0)));
  if (in_mirror) b.add(quad, b.material(mirror), Matrix4d().setTranslation(Vec3d(6, 3, 0)));
  // The mirror lies beside the ceiling. Both see the floor's middle along one direction.
  PathTracer tracer(b.snapshot(), in_mirror ? Vec3d(8, 2, 0) : Vec3d(4, 2, 0),
                    in_mirror ? Vec3d(6, 3, 0) : Vec3d(0, 0, 0));
  tracer.aovs = kGuideAovs;
  RunningStatistics statistics;
  for (uint32_t i = 0; i < static_cast<uint32_t>(testing::run_samples(4096)); ++i)
    statistics.add(tracer.trace(i).normal.y < 0 ? 1 : 0);
  return statistics;
}

// A surface that the camera sees sends two paths on, and shows a denoiser what one of them finds: in a mirror, where it
// sends one, it shows the same.
TEST(PathIntegrator, GuidesOfAShinySurfaceAreThoseOfOnePath) {
  const RunningStatistics direct = mirrored_features(false), reflected = mirrored_features(true);
  EXPECT_GT(direct.mean(), 0.05);
  EXPECT_LT(direct.mean(), 0.6);
  EXPECT_TRUE(plausible(z_test(direct, reflected)));
}

// What a walk costs of maxDepth: light that a body sends on to a floor and the floor to the body is there with two
// bounces, as with Lambert's diffuse.
TEST(PathIntegrator, AWalkIsOneBounce) {
  const auto mean = [](SubsurfaceMode mode, uint32_t max_depth) {
    SceneBuilder b;
    DisneyParameters wax = matt(Rgb(0.8f));
    wax.scatter_distance = Rgb(0.01f);
    b.add(b.prototype(testing::sphere_mesh(1, 32, true)), b.material(wax));
    b.add(b.prototype(testing::plane_mesh(20)), b.material(matt(Rgb(0.8f))),
          Matrix4d().setTranslation(Vec3d(0, -1.05, 0)));
    b.add(testing::constant_dome(1, false));
    PathTracer tracer(b.snapshot(), {0, -0.5, 4}, {0, -0.7, 0});
    tracer.settings.subsurface = mode;
    tracer.settings.max_depth = max_depth;
    return means_of_green(&tracer, 128, 16).mean();
  };
  const auto second = [&](SubsurfaceMode mode) { return mean(mode, 2) - mean(mode, 1); };
  const double lambert = second(SubsurfaceMode::lambert);
  EXPECT_GT(lambert, 0.05);
  EXPECT_NEAR(second(SubsurfaceMode::walk) / lambert, 1, 0.15);
  EXPECT_NEAR(second(SubsurfaceMode::diffusion) / lambert, 1, 0.15);
}

// Every AOV alone shows the bytes that it shows beside all others, and the color is the same whatever is bound.
TEST(PathIntegrator, BytesDoNotDependOnWhatElseIsBound) {
  SceneBuilder b;
  DisneyParameters skin, metal;
  skin.base_color = {0.9f, 0.6f, 0.45f};
  skin.scatter_distance = {0.1f, 0.05f, 0.03f};
  metal.metallic = 1;
  b.add(b.prototype(testing::sphere_mesh(0.5f, 12, true)), b.material(skin),
        Matrix4d().setTranslation(Vec3d(-0.4, 0.5, 0)));
  b.add(b.prototype(testing::sphere_mesh(0.4f, 8, false)), b.material(metal),
        Matrix4d().setTranslation(Vec3d(0.6, 0.4, 0.2)));
  b.add(b.prototype(testing::plane_mesh(3)), b.material({})).add(testing::constant_dome(0.5f, false));
  RenderRequest request;
  request.scene = b.snapshot();
  request.camera = testing::look_at({0, 1.5, 3}, {0, 0.4, 0}, 50);
  request.width = request.height = 24;
  request.data_window = {0, 0, 24, 24};
  request.settings.samples = 4;
  const auto color = testing::render(request)->resolve_float(Aov::color);
  request.aovs = ~AovSet{0};
  const auto all = testing::render(request);
  EXPECT_EQ(all->resolve_float(Aov::color), color);
  for (const AovInfo& info : kAovs) {
    const Aov aov = info.aov;
    request.aovs = aov_bit(aov);
    const auto alone = testing::render(request);
    EXPECT_EQ(alone->resolve_float(Aov::color), color) << info.name;
    if (info.is_integer()) {
      EXPECT_EQ(alone->resolve_int(aov), all->resolve_int(aov)) << info.name;
    } else {
      EXPECT_EQ(alone->resolve_float(aov), all->resolve_float(aov)) << info.name;
    }
  }
}

}  // namespace
}  // namespace alabaster
