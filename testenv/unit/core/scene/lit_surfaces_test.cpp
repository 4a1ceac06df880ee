#include "core/scene/lit_surfaces.h"

#include <gtest/gtest.h>

#include "core/subsurface/body.h"
#include "testenv/support/medium_bodies.h"

namespace alabaster {
namespace {

using testing::SceneBuilder;

Matrix4d moved(double x) {
  Matrix4d m;
  m.setTranslation(Vec3d(x, 0, 0));
  return m;
}

/// From -z: a camera that looks along -z from +z sees the dark side.
LightDescription sun_behind() {
  LightDescription sun;
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

TEST(LitSurfaces, AnObjectThatShadesTheBodyTakesItsLight) {
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
TEST(LitSurfaces, ManyBodiesHaveNone) {
  SceneBuilder b;
  const auto ball = b.prototype(testing::sphere_mesh(1, 8, false));
  const auto wax = b.material(testing::medium_only(0.8f, 0.2f));
  b.add(sun_behind());
  for (int i = 0; i < 300; ++i) b.add(ball, wax, moved(3 * i));
  const auto snapshot = b.snapshot();
  EXPECT_TRUE(std::none_of(snapshot->bodies.begin(), snapshot->bodies.end(),
                           [](const auto& body) { return body->lit != nullptr; }));
}

// A thin ball, whose walks nothing else guides, alone and as a union; the camera sees its dark side.
TEST(LitSurfaces, WalksThatAreGuidedToLightChangeNoMean) {
  for (const bool in_a_set : {false, true}) {
    SceneBuilder b;
    const auto ball = b.prototype(testing::sphere_mesh(1, 64, false));
    const auto wax = b.material(testing::medium_only(0.8f, 0.25f));
    b.add(ball, wax).add(ball, wax, moved(0.5)).add(sun_behind());
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
