// AOV ambientOcclusion against closed forms: the share of directions, weighted by the cosine, that nothing occludes.
#include <gtest/gtest.h>

#include "testenv/support/path_tracer.h"

namespace alabaster {
namespace {

using testing::matt;
using testing::PathTracer;
using testing::SceneBuilder;

const Vec3d kEye(0.3, 0.5, 0.2);

void add_plane(SceneBuilder* b, const Matrix4d& place, float size, float opacity = 1) {
  DisneyParameters p = matt(Rgb(0.5f));
  p.opacity = opacity;
  b->add(b->prototype(testing::plane_mesh(size)), b->material(p), place);
}

SceneBuilder floor_alone(float size = 100) {
  SceneBuilder b;
  add_plane(&b, Matrix4d().setTranslation(Vec3d(0.37, 0, 0.11)), size);  // no ray meets the edge of two triangles
  b.add(testing::constant_dome(1, true));
  return b;
}

double occlusion(PathTracer* tracer) {
  constexpr uint32_t kSamples = 4096;  // of which each multiple of 1/4096 is a stratum
  tracer->aovs |= aov_bit(Aov::ambient_occlusion);
  double sum = 0;
  for (uint32_t i = 0; i < kSamples; ++i) sum += double(tracer->trace(i).ambient_occlusion);
  return sum / kSamples;
}

double occlusion_in(SceneBuilder scene, float distance = 0, const Vec3d& target = {0, 0, 0}) {
  PathTracer tracer(scene.snapshot(), kEye, target);
  tracer.settings.ambient_occlusion_distance = distance;
  return occlusion(&tracer);
}

// promise: pipeline.aov.ambient_occlusion
TEST(AmbientOcclusion, AFloorAloneHasNone) {
  EXPECT_EQ(occlusion_in(floor_alone()), 1);
  EXPECT_EQ(occlusion_in(floor_alone(), 0, {0.3, 5, 0.3}), 0) << "the sky";
}

// A wall without an end hides half of the cosine-weighted hemisphere, however far away it is.
TEST(AmbientOcclusion, AWallHidesHalf) {
  for (const double away : {0.25, 3.0}) {
    SceneBuilder b = floor_alone(20000);
    const Matrix4d upright = Matrix4d().setAxisAngle(Vec3d(0, 0, 1), -1.5707963267948966);
    add_plane(&b,
              Matrix4d().setTranslation(Vec3d(0.2, 0, 0.1)) * upright * Matrix4d().setTranslation(Vec3d(-away, 0, 0)),
              20000);
    EXPECT_NEAR(occlusion_in(b), 0.5, 0.005) << away;
    EXPECT_EQ(occlusion_in(b, 0.2f), 1) << "it is farther away";
  }
}

// Of directions with a cosine c to the normal, a ceiling at height h is h / c away: those with c < h / r do not reach
// it within r, and they have (h / r)^2 of the weight.
TEST(AmbientOcclusion, ACeilingHidesWhatIsNearerThanTheDistance) {
  SceneBuilder b = floor_alone();
  add_plane(&b, Matrix4d().setTranslation(Vec3d(0.2, 1, 0.1)), 100);
  EXPECT_NEAR(occlusion_in(b), 0, 0.001);
  EXPECT_NEAR(occlusion_in(b, 2), 0.25, 0.005);
  EXPECT_NEAR(occlusion_in(b, 1.25f), 0.64, 0.005);
  EXPECT_EQ(occlusion_in(b, 0.99f), 1);
}

TEST(AmbientOcclusion, WhatIsPartlyThereHidesThatPart) {
  SceneBuilder b = floor_alone();
  add_plane(&b, Matrix4d().setTranslation(Vec3d(0.2, 1, 0.1)), 100, 0.25f);
  EXPECT_NEAR(occlusion_in(b), 0.75, 0.001);
}

// Facets with smooth normals stand for a curved surface, which hides nothing of itself where it is convex.
TEST(AmbientOcclusion, AConvexBodyHidesNothingOfItself) {
  SceneBuilder b;
  b.add(b.prototype(testing::sphere_mesh(1, 12, true)), b.material(matt(Rgb(0.5f))));
  const auto scene = b.snapshot();
  for (const Vec3d& eye : {Vec3d(3, 1, 0.4), Vec3d(-0.3, -2, 1.7), Vec3d(0.9, 0.2, 3)}) {
    PathTracer tracer(scene, eye);
    EXPECT_GT(occlusion(&tracer), 0.999);
  }
}

// promise: pipeline.aov.ambient_occlusion_samples
TEST(AmbientOcclusion, ColorIsTheSame) {
  SceneBuilder b = floor_alone();
  add_plane(&b, Matrix4d().setTranslation(Vec3d(0.2, 1, 0.1)), 100, 0.5f);
  PathTracer with(b.snapshot(), kEye), without(b.snapshot(), kEye);
  with.aovs |= aov_bit(Aov::ambient_occlusion);
  for (uint32_t i = 0; i < 256; ++i) EXPECT_EQ(with.trace(i).color, without.trace(i).color) << i;
  EXPECT_EQ(with.counters.rays(), without.counters.rays()) << "which allocate samples";
}

TEST(AmbientOcclusion, AHoldOutHasNone) {
  SceneBuilder b = floor_alone();
  b.description.instances.back().options.holdout = true;
  EXPECT_EQ(occlusion_in(b), 0);
}

}  // namespace
}  // namespace alabaster
