#include "core/scene/lit_surfaces.h"

#include <gtest/gtest.h>

#include "core/subsurface/body.h"
#include "testenv/support/medium_bodies.h"

namespace alabaster {
namespace {

using testing::SceneBuilder;

/// From -z: a camera that looks along -z from +z sees the dark side.
LightParameters sun_behind() {
  LightParameters sun;
  sun.type = LightType::distant;
  sun.light_to_world.setAxisAngle(Vec3d(0, 1, 0), 3.14159265);
  sun.intensity = 3;
  return sun;
}

TEST(LitSurfaces, OnlyUnevenLightIsFound) {
  SceneBuilder b;
  const auto ball = b.prototype(testing::sphere_mesh(1, 32, false));
  b.add(ball, b.material(testing::medium_only(0.8f, 0.2f)));
  EXPECT_FALSE(b.snapshot()->bodies[0]->lit->get()) << "no light";
  b.add(testing::constant_dome(0.02f, false));
  EXPECT_FALSE(b.snapshot(2)->bodies[0]->lit->get()) << "a dome";
  b.add(sun_behind());
  b.description.lights.back().intensity = 1e6f;
  const auto snapshot = b.snapshot(3);
  const LitSurface* const lit = snapshot->bodies[0]->lit->get();
  ASSERT_TRUE(lit);
  EXPECT_LT(lit->direction_from({0, 0, 0.8f}, 2).z, -0.6f);
}

TEST(LitSurfaces, ShadedBodyIsNotLit) {
  SceneBuilder b;
  b.add(b.prototype(testing::sphere_mesh(1, 32, false)), b.material(testing::medium_only(0.8f, 0.2f)));
  b.add(sun_behind());
  EXPECT_TRUE(b.snapshot()->bodies[0]->lit->get());
  Matrix4d behind;
  behind.setTranslation(Vec3d(0, 0, -4));
  b.add(b.prototype(testing::sphere_mesh(1.5f, 32, false)), b.material({}), behind);
  EXPECT_FALSE(b.snapshot(2)->bodies[0]->lit->get());
}

// Shadow rays of a forest would take long, before the first picture.
TEST(LitSurfaces, ManyBodiesGetNoLitSurfaces) {
  SceneBuilder b;
  const auto ball = b.prototype(testing::sphere_mesh(1, 8, false));
  const auto wax = b.material(testing::medium_only(0.8f, 0.2f));
  b.add(sun_behind());
  for (int i = 0; i < 300; ++i) b.add(ball, wax, testing::moved(3 * i));
  const auto snapshot = b.snapshot();
  EXPECT_TRUE(std::none_of(snapshot->bodies.begin(), snapshot->bodies.end(),
                           [](const auto& body) { return body->lit != nullptr; }));
}

/// The kappa beyond which too little of the sun's light comes through a ball of radius 1 to be looked for.
float largest_kappa_that_guides(int rings) {
  SceneBuilder b;
  b.add(b.prototype(testing::sphere_mesh(1, rings, false)), b.material(testing::medium_only(0.8f, 0.2f)));
  b.add(sun_behind());
  const auto snapshot = b.snapshot();
  const LitSurface* const lit = snapshot->bodies[0]->lit->get();
  float guides = 0, leads_nowhere = 64;
  while (lit && leads_nowhere - guides > 0.01f) {
    const float kappa = 0.5f * (guides + leads_nowhere);
    (lit->direction_from({0, 0, 0.9f}, kappa) != Vec3f(0, 0, 0) ? guides : leads_nowhere) = kappa;
  }
  return guides;
}

// A point stands for the area of many triangles: were it that of its own, light would come through a coarse mesh at a
// kappa that is larger by more than ln(16)/2 where a fine one has 16 times as many.
TEST(LitSurfaces, LightComesThroughAFineMeshAsThroughACoarseOne) {
  const float coarse = largest_kappa_that_guides(16);
  EXPECT_GT(coarse, 2);
  EXPECT_LT(coarse, 8);
  EXPECT_NEAR(largest_kappa_that_guides(64), coarse, 0.4f);
}

// A thin ball, whose walks nothing else guides, alone and as a union; the camera sees its dark side.
TEST(LitSurfaces, WalksThatAreGuidedToLightChangeNoMean) {
  for (const bool in_a_set : {false, true}) {
    SceneBuilder b;
    const auto ball = b.prototype(testing::sphere_mesh(1, 64, false));
    const auto wax = b.material(testing::medium_only(0.8f, 0.25f));
    b.add(ball, wax).add(ball, wax, testing::moved(0.5)).add(sun_behind());
    if (in_a_set)
      for (auto& instance : b.description.instances) instance.subsurface_set = "pair";
    RenderRequest request = testing::request_of(&b, testing::look_at({0.25, 0, 5}, {0.25, 0, 0}, 24), 128);
    ASSERT_TRUE(request.scene->bodies[0]->lit->get());
    RenderProgress progress;
    const auto guided = testing::render(request, &progress);
    EXPECT_EQ(progress.counters.walk_lost, 0u);
    request.settings.walk_guiding = false;
    request.settings.seed = 7;
    const auto plain = testing::render(request, &progress);
    testing::expect_same(*guided, *plain, in_a_set ? "guided in a union" : "guided");
  }
}

}  // namespace
}  // namespace alabaster
