// Light paths bring as much light as they take from camera paths.
#include "core/integrator/light_path.h"

#include <gtest/gtest.h>

#include "testenv/support/ball_on_floor.h"
#include "testenv/support/path_tracer.h"
#include "testenv/support/z_test.h"

namespace alabaster {
namespace {

using testing::metal;
using testing::RunningStatistics;
using testing::SceneBuilder;
using testing::small_light;

constexpr int kSide = 16;  // pixels of the film
DisneyParameters wax(float distance) {
  DisneyParameters p;
  p.base_color = {0.9f, 0.7f, 0.5f};
  p.scatter_distance = Rgb(distance);
  p.specular = 1;
  p.roughness = 0.35f;
  return p;
}

struct Stage {
  SceneBuilder builder;
  CameraParameters camera = testing::look_at({0.3, 4, 4}, {0, 0, 0}, 40);
  IntegratorSettings settings = integrator_settings({});
  uint32_t caster = 0;  // light paths begin there

  /// A floor, and a ball that stands on it behind what the camera looks at.
  explicit Stage(const DisneyParameters& ball = metal(0.4f), const DisneyParameters& floor = testing::matt(Rgb(0.5f)),
                 const LightParameters& light = small_light()) {
    testing::add_ball_on_floor(ball, floor, light, &builder);
  }
};

struct Shares {
  RunningStatistics taken;   // of a camera sample, by light paths
  RunningStatistics landed;  // of a light path, on all pixels, in units of a sample's light
  RunningStatistics missed;  // taken less landed
};

/// Camera samples and light paths in pairs. `paths` of a sample of the frame are weighed as `weighed_as`.
Shares measure_shares(Stage* stage, uint32_t samples, uint32_t paths = 256, uint32_t weighed_as = 256) {
  const auto scene = stage->builder.snapshot();
  const Camera camera(stage->camera, kSide, kSide, scene->origin);
  RenderCounters counters;
  LightPathPlan plan{weighed_as, {{stage->caster, 1}}, {}};
  plan.spread_chances(*scene);
  LightPathPlan traced = plan;
  traced.paths = paths;
  const PathContext alone{*scene, camera, stage->settings, counters};
  PathContext shared = alone, landing = alone;
  shared.light_paths = &plan;
  landing.light_paths = &traced;
  const PathIntegrator trace_camera = select_path_integrator(scene->features, stage->settings, false);
  const LightPathTracer trace_light = select_light_path_tracer(scene->features, stage->settings);
  Shares shares;
  std::vector<LightLanding> landings;
  Rng rng(testing::run_seed(7), 3);
  for (uint32_t i = 0; i < testing::run_samples(samples); ++i) {
    const float x = rng.uniform(), y = rng.uniform(), lens = rng.uniform();
    const Ray ray = camera.generate_ray(Vec2f(x, y) * float(kSide), {lens, rng.uniform()});
    const PixelSampler sampler(testing::run_seed(5u), i);
    const double taken =
        double(trace_camera(alone, ray, sampler).color.g) - double(trace_camera(shared, ray, sampler).color.g);
    landings.clear();
    trace_light(landing, PixelSampler(testing::run_seed(6u), i), &landings);
    double landed = 0;
    for (const LightLanding& l : landings)
      if (l.film.x >= 0 && l.film.x < kSide && l.film.y >= 0 && l.film.y < kSide) landed += double(l.color.g);
    landed *= double(paths) / (kSide * kSide);
    shares.taken.add(taken);
    shares.landed.add(landed);
    shares.missed.add(taken - landed);
  }
  return shares;
}

/// Light paths bring what they take from camera paths, and that is something.
void expect_shared(Stage* stage, uint32_t samples = 100000) {
  const Shares shares = measure_shares(stage, samples);
  const auto result = z_test(shares.missed, 0);
  EXPECT_TRUE(plausible(result)) << result.report << ", taken " << shares.taken.mean() << ", landed "
                                 << shares.landed.mean();
  EXPECT_GT(shares.landed.mean(), 8 * shares.missed.standard_error()) << "or the comparison proves nothing";
}

TEST(LightPath, AddsWhatCameraPathsLeaveOut) {
  Stage stage;
  expect_shared(&stage);
}

TEST(LightPath, AddsWhatCameraPathsLeaveOutThroughALens) {
  Stage stage;
  stage.camera.focal_length = 50, stage.camera.horizontal_aperture *= 50, stage.camera.vertical_aperture *= 50;
  stage.camera.f_stop = 50 / (2 * 0.4f);  // a lens of radius 0.4
  stage.camera.focus_distance = 3;
  expect_shared(&stage);
}

TEST(LightPath, AddsWhatCameraPathsLeaveOutForAnOrthographicCamera) {
  Stage stage;
  stage.camera.orthographic = true;
  stage.camera.horizontal_aperture = stage.camera.vertical_aperture = 3;
  expect_shared(&stage);
}

TEST(LightPath, AddsWhatCameraPathsLeaveOutOfDistantLightsAndASky) {
  Stage stage(metal(0.4f), testing::matt(Rgb(0.5f)), small_light(LightType::distant));
  stage.builder.add(testing::constant_dome(0.5f, true));
  expect_shared(&stage);
}

// One light is chosen of many, and some lie below the horizon.
TEST(LightPath, AddsWhatCameraPathsLeaveOutOfManyLights) {
  Stage stage;
  for (int i = 0; i < 40; ++i) {
    LightParameters light = small_light();
    light.light_to_world = Matrix4d().setTranslation(Vec3d(3 * std::cos(i), 0.2 * i - 2, 3 * std::sin(i)));
    light.color = Rgb(20.0f);
    stage.builder.add(light);
  }
  expect_shared(&stage, 200000);
}

// The ball scatters and has a coat; the floor reflects, too.
TEST(LightPath, AddsWhatCameraPathsLeaveOutFromABodyToAGlossyFloor) {
  DisneyParameters coated = wax(0.2f), floor;
  coated.clearcoat = 1;
  floor.roughness = 0.6f;
  Stage stage(coated, floor);
  expect_shared(&stage, 200000);
}

// Light that lands on sheets which are seen from one side alone, or partly there: camera paths come the other way.
TEST(LightPath, AddsWhatCameraPathsLeaveOutThroughSheets) {
  Stage stage;
  DisneyParameters film = testing::matt(Rgb(0.5f));
  film.opacity = 0.5f;
  SceneBuilder& b = stage.builder;
  const auto sheet = b.prototype(testing::plane_mesh(1.5f));
  b.add(sheet, b.material(film), Matrix4d().setTranslation(Vec3d(0.2, 0.3, 0.4)));
  b.add(sheet, b.material(testing::matt(Rgb(0.7f))),
        Matrix4d().setAxisAngle(Vec3d(1, 0, 0), 1.3) * Matrix4d().setTranslation(Vec3d(-0.6, 0.4, 0.3)));
  b.description.instances.back().options.double_sided = false;
  b.add(sheet, b.material(testing::matt(Rgb(0.7f))),
        Matrix4d().setAxisAngle(Vec3d(1, 0, 0), -1.7) * Matrix4d().setTranslation(Vec3d(0.6, 0.4, 0.3)));
  b.description.instances.back().options.double_sided = false;
  ASSERT_TRUE(b.snapshot()->features.see_through);
  expect_shared(&stage, 200000);
}

// A mesh of large and small triangles, stretched and mirrored.
TEST(LightPath, AddsWhatCameraPathsLeaveOutFromStretchedMeshes) {
  Stage stage;
  stage.builder.description.instances[0].object_to_world =
      Matrix4d().setScale(Vec3d(-1.5, 0.7, 0.8)) * Matrix4d().setTranslation(Vec3d(0, 0.8, -1.2));
  expect_shared(&stage);
}

// Each face twice: a ray meets one of the two.
TEST(LightPath, AddsWhatCameraPathsLeaveOutFromDoubledFaces) {
  Stage stage;
  Mesh doubled = testing::sphere_mesh(1, 24, true);
  const auto once = doubled.triangles;
  doubled.triangles.insert(doubled.triangles.end(), once.begin(), once.end());
  if (!doubled.normal_triangles.empty()) {
    const auto normals = doubled.normal_triangles;
    doubled.normal_triangles.insert(doubled.normal_triangles.end(), normals.begin(), normals.end());
  }
  stage.builder.description.instances[0].prototype = stage.builder.prototype(std::move(doubled));
  expect_shared(&stage);
}

// The dome is sampled where light enters a body, and left to the lobes where the body is too dense for a walk.
TEST(LightPath, AddsWhatCameraPathsLeaveOutOfASkyOverBodies) {
  for (const float distance : {0.2f, 1e-7f}) {
    SCOPED_TRACE(distance);
    Stage stage(wax(distance));
    stage.builder.add(testing::constant_dome(0.5f, true));
    expect_shared(&stage, 200000);
  }
}

// Walls that scatter all around the camera. A diffusion profile has no way out of them, and light meets their lobes.
TEST(LightPath, AddsWhatCameraPathsLeaveOutWithinBodies) {
  for (const SubsurfaceMode mode : {SubsurfaceMode::diffusion, SubsurfaceMode::walk}) {
    Stage stage;
    stage.settings.subsurface = mode;
    SceneBuilder& b = stage.builder;
    b.add(b.prototype(testing::sphere_mesh(8, 24, true)), b.material(wax(0.2f)));
    const Shares shares = measure_shares(&stage, 20000);
    const auto result = z_test(shares.missed, 0);
    EXPECT_TRUE(plausible(result));
  }
}

// The camera stands between two glasses: in the box around both, in neither of them.
TEST(LightPath, AddsWhatCameraPathsLeaveOutBetweenGlasses) {
  Stage stage;
  DisneyParameters glass;
  glass.spec_trans = 1;
  SceneBuilder& b = stage.builder;
  const auto ball = b.prototype(testing::sphere_mesh(0.3f, 16, true));
  b.add(ball, b.material(glass), Matrix4d().setTranslation(Vec3d(-4, 0.5, -4)));
  b.add(ball, b.material(glass), Matrix4d().setTranslation(Vec3d(4, 6, 6)));
  ASSERT_TRUE(b.snapshot()->clear_bodies.contains({0.3f, 1, 1}));
  expect_shared(&stage);
}

TEST(LightPath, AWrongNumberOfPathsFails) {
  Stage stage;
  const auto result = z_test(measure_shares(&stage, 100000, 256, 2048).missed, 0);
  EXPECT_TRUE(noticed(result));
}

TEST(LightPath, ReducesTheNoiseOfCaustics) {
  Stage stage(metal(0.15f));
  const auto scene = stage.builder.snapshot();
  const Camera camera(stage.camera, kSide, kSide, scene->origin);
  RenderCounters counters;
  LightPathPlan plan{256, {{0, 1}}, {}};
  plan.spread_chances(*scene);
  PathContext context{*scene, camera, stage.settings, counters};
  const PathIntegrator trace = select_path_integrator(scene->features, stage.settings, false);
  const auto variance = [&] {
    RunningStatistics statistics;
    for (uint32_t i = 0; i < 200000; ++i)
      statistics.add(double(trace(context, camera.generate_ray({8.5f, 9.5f}, {0, 0}), PixelSampler(9, i)).color.g));
    return statistics.variance();
  };
  const double alone = variance();
  context.light_paths = &plan;
  EXPECT_LT(variance(), alone / 20);
}

TEST(LightPath, LightPathsArePlannedForNoisyReflections) {
  constexpr float kLevel = 0.05f;  // of the floor
  const auto plan_of = [](Stage stage) {
    const auto scene = stage.builder.snapshot();
    const Camera camera(stage.camera, kSide, kSide, scene->origin);
    RenderCounters counters;
    return plan_light_paths({*scene, camera, stage.settings, counters}, find_casters(*scene, stage.settings),
                            {kSide, kSide}, kLevel);
  };
  const LightPathPlan plan = plan_of(Stage(metal(0.15f)));
  ASSERT_EQ(plan.casters.size(), 1u);
  EXPECT_EQ(plan.casters[0].instance, 0u);
  EXPECT_FLOAT_EQ(plan.casters[0].chance, 1);
  EXPECT_EQ(plan.paths, uint32_t(kSide * kSide / 32));
  EXPECT_TRUE(plan_of(Stage(testing::matt(Rgb(0.5f)))).empty()) << "nothing shines";
  Stage direct(metal(0.15f));
  direct.settings.max_depth = 1;
  EXPECT_TRUE(plan_of(std::move(direct)).empty()) << "no light comes by way of a second surface";
}

}  // namespace
}  // namespace alabaster
