// Shadow catchers against closed forms: the share of the lights' light that what is no catcher keeps away.
#include <gtest/gtest.h>

#include "core/film/film_tile.h"
#include "testenv/support/path_tracer.h"

namespace alabaster {
namespace {

using testing::matt;
using testing::PathTracer;
using testing::SceneBuilder;

const Vec3d kEye(0.3, 0.5, 0.2);

void add_plane(SceneBuilder* b, const Matrix4d& place, float size, bool catcher, float opacity = 1) {
  DisneyParameters p = matt(Rgb(0.5f));
  p.opacity = opacity;
  b->add(b->prototype(testing::plane_mesh(size)), b->material(p), place);
  b->description.instances.back().options.shadow_catcher = catcher;
}

SceneBuilder catching_floor() {
  SceneBuilder b;
  add_plane(&b, Matrix4d().setTranslation(Vec3d(0.37, 0, 0.11)), 20000, true);  // no ray meets two triangles' edge
  return b;
}

void add_sun(SceneBuilder* b, const Rgb& color, double tilt) {
  LightParameters sun;
  sun.type = LightType::distant;
  sun.angle = 0;
  sun.color = color;
  sun.light_to_world = Matrix4d().setAxisAngle(Vec3d(1, 0, 0), -1.5707963267948966 + tilt);
  b->add(sun);
}

void add_ceiling(SceneBuilder* b, bool catcher, float opacity = 1) {
  add_plane(b, Matrix4d().setTranslation(Vec3d(0.2, 1, 0.1)), 20000, catcher, opacity);
}

struct Caught {
  std::array<float, 3> shadow;
  std::array<float, 4> color;
};

Caught caught_in(SceneBuilder scene, uint32_t samples = 16) {
  PathTracer tracer(scene.snapshot(), kEye);
  tracer.aovs |= aov_bit(Aov::shadow);
  FilmTile tile(1, tracer.aovs);
  for (uint32_t i = 0; i < samples; ++i) tile.add(0, tracer.trace(i));
  Caught caught{};
  tile.resolve(0, Aov::shadow, caught.shadow.data());
  tile.resolve(0, Aov::color, caught.color.data());
  float alpha = 0;
  tile.resolve(0, Aov::alpha, &alpha);
  EXPECT_EQ(alpha, caught.color[3]);
  return caught;
}

// promise: artists.shadow_catcher
TEST(ShadowCatcher, OfTwoSunsTheOneThatIsHiddenIsMissing) {
  // A wall without an end to one side: the sun that is tilted to the other side passes it.
  SceneBuilder b = catching_floor();
  add_sun(&b, {3, 1, 0}, 0.5);
  add_sun(&b, {1, 1, 2}, -0.5);
  const Caught open = caught_in(b);
  EXPECT_EQ(open.shadow, (std::array<float, 3>{0, 0, 0}));
  EXPECT_EQ(open.color, (std::array<float, 4>{0, 0, 0, 0})) << "nothing of the catcher is seen";
  const Matrix4d upright = Matrix4d().setAxisAngle(Vec3d(1, 0, 0), 1.5707963267948966);
  add_plane(&b, upright * Matrix4d().setTranslation(Vec3d(0.1, 0, -1)), 20000, false);
  const Caught one = caught_in(b);
  const bool first = one.shadow[2] == 0;  // the red one is hidden
  EXPECT_NEAR(one.shadow[0], first ? 0.75 : 0.25, 1e-5);
  EXPECT_NEAR(one.shadow[1], 0.5, 1e-5);
  EXPECT_NEAR(one.shadow[2], first ? 0 : 1, 1e-5);
  EXPECT_NEAR(one.color[3], 0.5, 1e-5) << "of 8 parts of light 4 are missing";
  EXPECT_EQ(one.color[0] + one.color[1] + one.color[2], 0);
}

// A wall without an end hides half of the cosine-weighted sky.
TEST(ShadowCatcher, AWallHidesHalfOfTheSky) {
  SceneBuilder b = catching_floor();
  b.add(testing::constant_dome(1, false));
  const Matrix4d upright = Matrix4d().setAxisAngle(Vec3d(0, 0, 1), -1.5707963267948966);
  const Matrix4d place =
      Matrix4d().setTranslation(Vec3d(0.2, 0, 0.1)) * upright * Matrix4d().setTranslation(Vec3d(-0.5, 0, 0));
  add_plane(&b, place, 20000, false);
  EXPECT_NEAR(caught_in(b, 4096).color[3], 0.5, 0.005);
  b.description.instances.back().options.shadow_catcher = true;
  EXPECT_EQ(caught_in(b, 4096).color[3], 0) << "a catcher casts no shadow on another one";
}

TEST(ShadowCatcher, WhatIsBehindAnotherCatcherCastsNoShadow) {
  SceneBuilder b = catching_floor();
  add_sun(&b, Rgb(1.0f), 0);
  add_ceiling(&b, true);
  EXPECT_EQ(caught_in(b).color[3], 0);
  add_plane(&b, Matrix4d().setTranslation(Vec3d(0.2, 2, 0.1)), 20000, false);
  EXPECT_EQ(caught_in(b).color[3], 0) << "the plate has the real ceiling's shadow there";
}

TEST(ShadowCatcher, WhatIsPartlyThereCastsThatPart) {
  for (const float opacity : {0.25f, 1.0f}) {
    SceneBuilder b = catching_floor();
    add_sun(&b, Rgb(1.0f), 0.3);
    add_ceiling(&b, false, opacity);
    EXPECT_NEAR(caught_in(b).color[3], opacity, 1e-5);
  }
}

TEST(ShadowCatcher, AHoldOutIsNone) {
  SceneBuilder b = catching_floor();
  b.description.instances.front().options.holdout = true;
  add_sun(&b, Rgb(1.0f), 0);
  add_ceiling(&b, false);
  EXPECT_EQ(caught_in(b).color[3], 0);
}

// A catcher that half of the samples meet: alpha is the mean of both.
TEST(ShadowCatcher, AFilmBeforeItMixesWithIt) {
  SceneBuilder b = catching_floor();
  add_sun(&b, Rgb(1.0f), 0);
  add_plane(&b, Matrix4d().setTranslation(Vec3d(0.2, 0.25, 0.1)), 20000, false, 0.5f);  // between it and the camera
  const Caught caught = caught_in(b, 4096);
  EXPECT_NEAR(caught.color[3], 0.5 + 0.5 * 0.5, 0.02) << "the film, and half a shadow where it is not there";
  EXPECT_NEAR(caught.shadow[1], 0.25, 0.01);
}

// Where it has no light there is none to miss.
TEST(ShadowCatcher, InTheDarkItIsAHole) {
  SceneBuilder b = catching_floor();
  add_ceiling(&b, false);
  EXPECT_EQ(caught_in(b).color, (std::array<float, 4>{0, 0, 0, 0}));
}

}  // namespace
}  // namespace alabaster
