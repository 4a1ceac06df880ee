// Hold-outs and what the camera alone does not see: properties of an instance that other rays take no notice of.
#include <gtest/gtest.h>

#include "testenv/support/path_tracer.h"
#include "testenv/support/z_test.h"

namespace alabaster {
namespace {

using testing::matt;
using testing::PathTracer;
using testing::RunningStatistics;
using testing::SceneBuilder;

const Vec3d kEye(0.3, 3, 0.2);
const Matrix4d kAside = Matrix4d().setTranslation(Vec3d(0.37, 0, 0.11));  // no ray meets the edge of two triangles

Matrix4d at_height(double y) {
  return kAside * Matrix4d().setTranslation(Vec3d(0, y, 0));
}

InstanceDescription& last(SceneBuilder* b) {
  return b->description.instances.back();
}

// A plane that glows, below a sky that the camera sees.
SceneBuilder glowing_plane(bool holdout, float scatter_distance = 0) {
  SceneBuilder b;
  DisneyParameters glow = matt(Rgb(0.5f));
  glow.emission = Rgb(1.0f);
  glow.scatter_distance = Rgb(scatter_distance);
  b.add(b.prototype(testing::plane_mesh(4)), b.material(glow), kAside).add(testing::constant_dome(1, true));
  last(&b).options.holdout = holdout;
  last(&b).prim_id = 7;
  return b;
}

TEST(HoldOut, TheCameraSeesAHoleWithDepthAndIds) {
  for (const float distance : {0.0f, 0.1f}) {
    FilmSample samples[2];
    for (const bool holdout : {false, true}) {
      PathTracer tracer(glowing_plane(holdout, distance).snapshot(), kEye);
      tracer.aovs |= aov_bit(Aov::depth) | aov_bit(Aov::prim_id);
      samples[holdout] = tracer.trace(0);
    }
    EXPECT_GT(samples[0].color.g, 1) << distance;
    EXPECT_EQ(samples[0].alpha, 1) << distance;
    EXPECT_EQ(samples[1].color, Rgb(0.0f)) << distance;
    EXPECT_EQ(samples[1].alpha, 0) << distance;
    EXPECT_EQ(samples[1].prim_id, 7) << distance;
    EXPECT_EQ(samples[1].camera_depth, samples[0].camera_depth) << distance;
    EXPECT_LT(samples[1].depth, 1) << distance;
  }
}

TEST(HoldOut, LayersAddUpToTheHole) {
  PathTracer tracer(glowing_plane(true).snapshot(), kEye);
  LightLayers layers;
  layers[LightLayers::kSeen] = Rgb(9.0f);
  EXPECT_EQ(tracer.trace(0, &layers).alpha, 0);
  for (const Rgb& part : layers.parts) EXPECT_EQ(part, Rgb(0.0f));
}

// Half of the samples see the sky or the hold-out through the film, and the others the film.
TEST(HoldOut, FilmsMixWithIt) {
  for (const bool film_is_hole : {true, false}) {
    SceneBuilder b = glowing_plane(!film_is_hole);
    DisneyParameters film = matt(Rgb(0.0f));
    film.opacity = 0.5f;
    b.add(b.prototype(testing::plane_mesh(4)), b.material(film), at_height(1));
    last(&b).options.holdout = film_is_hole;
    PathTracer tracer(b.snapshot(), kEye);
    RunningStatistics alpha;
    for (uint32_t i = 0; i < testing::run_samples(4096u); ++i) {
      const FilmSample sample = tracer.trace(i);
      EXPECT_EQ(sample.alpha == 1 && sample.color.g > 0, sample.alpha == 1 && film_is_hole) << i;
      alpha.add(double(sample.alpha));
    }
    const auto result = z_test(alpha, 0.5);
    EXPECT_TRUE(plausible(result));
  }
}

// A light before it that the camera sees stays in the picture.
TEST(HoldOut, LightsBeforeItShow) {
  SceneBuilder b = glowing_plane(true);
  LightParameters panel;
  panel.width = panel.height = 2;
  panel.intensity = 3;
  panel.visible_to_camera = true;
  panel.light_to_world = Matrix4d().setAxisAngle(Vec3d(1, 0, 0), M_PI / 2) * at_height(1);
  b.add(panel);
  const FilmSample sample = PathTracer(b.snapshot(), kEye).trace(0);
  EXPECT_EQ(sample.color, Rgb(3.0f));
  EXPECT_EQ(sample.alpha, 1);
}

// Shadows, reflections and bounced light: the same bits, whether the wall is a hold-out, is hidden from the camera, or
// neither. `above`: the camera would see it before the floor.
std::vector<Rgb> floor_beside_a_wall(bool holdout, CameraCull cull, double above, float roughness) {
  SceneBuilder b;
  DisneyParameters floor;
  floor.metallic = 1;
  floor.roughness = roughness;
  DisneyParameters wall = matt(Rgb(0.8f, 0.2f, 0.1f));
  wall.emission = Rgb(0.1f);
  b.add(b.prototype(testing::plane_mesh(6)), b.material(floor), kAside);
  b.add(b.prototype(testing::plane_mesh(1)), b.material(wall),
        Matrix4d().setAxisAngle(Vec3d(0, 0, 1), 1.2) * Matrix4d().setTranslation(Vec3d(above > 0 ? 0.2 : -1.5, 1, 0)));
  last(&b).options.holdout = holdout;
  last(&b).options.camera_cull = cull;
  b.add(testing::constant_dome(1, true));
  PathTracer tracer(b.snapshot(), kEye);
  std::vector<Rgb> colors;
  for (uint32_t i = 0; i < 64; ++i) colors.push_back(tracer.trace(i).color);
  return colors;
}

TEST(HoldOut, OtherRaysSeeIt) {
  for (const float roughness : {0.0f, 0.4f}) {
    const auto as_usual = floor_beside_a_wall(false, CameraCull::none, 0, roughness);
    EXPECT_EQ(floor_beside_a_wall(true, CameraCull::none, 0, roughness), as_usual) << roughness;
    EXPECT_EQ(floor_beside_a_wall(false, CameraCull::all, 0, roughness), as_usual) << roughness;
    EXPECT_NE(floor_beside_a_wall(false, CameraCull::all, 1, roughness), as_usual) << roughness << ": the wall counts";
  }
}

// The camera is not in a body that it passes, or whose way out it does not see.
TEST(CameraCull, HidesABodyAboutTheCamera) {
  DisneyParameters glass;
  glass.spec_trans = 1;
  glass.attenuation_color = Rgb(0.1f);
  glass.attenuation_distance = 1;
  for (const CameraCull cull : {CameraCull::none, CameraCull::front, CameraCull::back, CameraCull::all}) {
    SceneBuilder b;
    b.add(b.prototype(testing::sphere_mesh(5, 24, false)), b.material(glass)).add(testing::constant_dome(1, true));
    last(&b).options.camera_cull = cull;
    const FilmSample sample = PathTracer(b.snapshot(), kEye).trace(0);
    const bool hidden = cull == CameraCull::back || cull == CameraCull::all;
    EXPECT_EQ(sample.color == Rgb(1.0f), hidden) << int(cull) << " " << sample.color.g;
  }
}

TEST(CameraCull, AllHidesBothSidesFromTheCameraAndShades) {
  for (const double turn : {0.0, M_PI}) {
    SceneBuilder b;
    b.add(b.prototype(testing::plane_mesh(2)), b.material(matt(Rgb(0.8f))), kAside);
    last(&b).prim_id = 3;
    b.add(b.prototype(testing::plane_mesh(2)), b.material(matt(Rgb(0.8f))),
          Matrix4d().setAxisAngle(Vec3d(1, 0, 0), turn) * at_height(1));
    last(&b).prim_id = 4;
    last(&b).options.camera_cull = CameraCull::all;
    LightParameters sun;
    sun.type = LightType::distant;
    sun.angle = 0;
    sun.light_to_world = Matrix4d().setAxisAngle(Vec3d(1, 0, 0), -M_PI / 2);
    b.add(sun);
    PathTracer tracer(b.snapshot(), kEye);
    tracer.aovs |= aov_bit(Aov::prim_id);
    tracer.settings.max_depth = 1;
    const FilmSample sample = tracer.trace(0);
    EXPECT_EQ(sample.prim_id, 3) << turn;
    EXPECT_EQ(sample.color.g, 0) << turn << ": it lies in the shadow";
    EXPECT_EQ(sample.alpha, 1) << turn;
  }
}

}  // namespace
}  // namespace alabaster
