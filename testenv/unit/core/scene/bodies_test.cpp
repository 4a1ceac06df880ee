#include "core/scene/bodies.h"

#include <gtest/gtest.h>

#include "core/subsurface/body.h"
#include "testenv/support/material_testing.h"
#include "testenv/support/medium_bodies.h"
#include "testenv/support/memory_texture.h"

namespace alabaster {
namespace {

using testing::SceneBuilder;

DisneyParameters wax(float scatter_distance) {
  DisneyParameters p;
  p.base_color = {0.9f, 0.6f, 0.45f};
  p.scatter_distance = Rgb(scatter_distance);
  return p;
}

TEST(Bodies, OnlyScatteringMaterialsMakeBodies) {
  SceneBuilder b;
  const auto sphere = b.prototype(testing::sphere_mesh(1, 8, false));
  b.add(sphere, b.material({})).add(sphere, b.material(wax(0.1f)), testing::moved(3));
  const auto snapshot = b.snapshot();
  EXPECT_EQ(snapshot->instances[0].body, nullptr);
  ASSERT_NE(snapshot->instances[1].body, nullptr);
  EXPECT_FALSE(snapshot->instances[1].body->is_union());
  EXPECT_TRUE(snapshot->features.subsurface);
}

// A material that no face uses costs nothing: no shells, no body, no integrator that walks.
TEST(Bodies, AMaterialThatNoFaceUsesMakesNone) {
  SceneBuilder b;
  Mesh mesh = testing::sphere_mesh(1, 8, false);
  mesh.triangle_material.assign(mesh.triangles.size(), 0);
  const auto prototype = b.prototype(mesh);
  b.add(prototype, b.material({}));
  b.description.instances.back().materials.push_back(b.material(wax(0.1f)));
  const auto without = b.snapshot();
  EXPECT_EQ(without->instances[0].body, nullptr);
  EXPECT_FALSE(without->features.subsurface);
  mesh.triangle_material[5] = 1;
  b.description.instances[0].prototype = b.prototype(mesh);
  const auto with = b.snapshot(2);
  EXPECT_NE(with->instances[0].body, nullptr);
  EXPECT_TRUE(with->features.subsurface);
}

TEST(Bodies, MediaAreMadeAtCommitUnlessATextureVariesThem) {
  SceneBuilder b;
  const auto sphere = b.prototype(testing::sphere_mesh(1, 8, false));
  const auto constant = b.material(wax(0.1f));
  auto textured = std::make_shared<DisneyMaterial>(*constant);
  testing::connect("baseColor", std::make_shared<testing::MemoryTexture>(1, std::vector<Rgb>{Rgb(1.0f)}),
                   textured.get());
  b.add(sphere, constant).add(sphere, textured, testing::moved(3)).add(sphere, constant, testing::moved(6));
  const auto snapshot = b.snapshot();
  const auto media = [&](size_t i) { return snapshot->instances[i].body->members[0].media[0]; };
  ASSERT_TRUE(media(0));
  EXPECT_FALSE(media(1));
  EXPECT_EQ(media(0), media(2)) << "one material, one set of media";
  for (const AlbedoInversion inversion : {AlbedoInversion::chiang2016, AlbedoInversion::exact}) {
    const Medium expected = make_medium({0.9f, 0.6f, 0.45f}, Rgb(0.1f), inversion);
    const WalkMedium& made = (*media(0))[inversion];
    EXPECT_EQ(made.medium.one_minus_alpha, expected.one_minus_alpha);
    EXPECT_EQ(made.medium.sigma_t, expected.sigma_t);
  }
}

// Thirty mean free paths decide, for an object alone, for one that overlaps itself, and for the members of a set.
TEST(Bodies, ShortcutsArePlannedByRoomInUnionsToo) {
  const Mesh sphere = testing::sphere_mesh(1, 16, false);
  Mesh shifted = sphere;
  for (Vec3f& p : shifted.points) p.x += 0.5f;
  Mesh overlapping = testing::merged(sphere, shifted);
  overlapping.bounds = {};
  for (const Vec3f& p : overlapping.points) overlapping.bounds.extend(p);
  for (const bool wide : {false, true}) {
    SceneBuilder b;
    const auto material = b.material(wax(wide ? 0.01f : 0.2f));
    b.add(b.prototype(sphere), material).add(b.prototype(overlapping), material, testing::moved(5));
    b.add(b.prototype(sphere), material, testing::moved(10)).add(b.prototype(sphere), material, testing::moved(10.5));
    b.description.instances[2].subsurface_set = b.description.instances[3].subsurface_set = "pair";
    const auto snapshot = b.snapshot();
    EXPECT_FALSE(snapshot->instances[0].body->is_union());
    EXPECT_TRUE(snapshot->instances[1].body->is_union());
    EXPECT_EQ(snapshot->instances[2].body, snapshot->instances[3].body);
    for (const Instance& instance : snapshot->instances) {
      const auto& member = instance.body->members[instance.member];
      EXPECT_EQ(member.room_to_guide, wide);
      EXPECT_EQ(member.room_for_spheres, wide);
      EXPECT_EQ(member.distances != nullptr, wide);
    }
  }
}

// Walks with and without sphere steps agree in a union: a set of two overlapping spheres, lit from one side.
// promise: trade_off.bias.walk
TEST(Bodies, SphereStepsInAUnionChangeNoMean) {
  SceneBuilder b;
  const auto sphere = b.prototype(testing::sphere_mesh(1, 64, false));
  const auto material = b.material(testing::medium_only(0.95f, 0.012f));
  b.add(sphere, material).add(sphere, material, testing::moved(0.5));
  for (auto& instance : b.description.instances) instance.subsurface_set = "pair";
  LightParameters sun;
  sun.type = LightType::distant;
  sun.light_to_world.setAxisAngle(Vec3d(0, 1, 0), 1.2);
  sun.intensity = 3;
  b.add(sun).add(testing::constant_dome(0.5f, false));
  RenderRequest request = testing::request_of(&b, testing::look_at({0.25, 0, 5}, {0.25, 0, 0}, 24), 96);
  RenderProgress with, without;
  const auto stepped = testing::render(request, &with);
  request.settings.walk_sphere_steps = false;
  request.settings.seed = 7;
  const auto plain = testing::render(request, &without);
  EXPECT_GT(with.counters.walk_sphere_steps, with.counters.walks / 10);
  EXPECT_EQ(without.counters.walk_sphere_steps, 0u);
  EXPECT_EQ(with.counters.walk_lost, 0u);
  testing::expect_same(*stepped, *plain, "sphere steps in a union");
}

// Behind a plane the medium has no end: walks are guided, however flat its bounds are.
TEST(Bodies, OpenPlanesAreGuided) {
  SceneBuilder b;
  b.add(b.prototype(testing::plane_mesh(2)), b.material(wax(0.01f)));
  EXPECT_TRUE(b.snapshot()->instances[0].body->members[0].room_to_guide);
}

// A slot without triangles plans no shortcut: its long distance would switch off those of the others.
TEST(Bodies, AMaterialThatNoFaceUsesPlansNothing) {
  SceneBuilder b;
  Mesh mesh = testing::sphere_mesh(1, 16, false);
  mesh.triangle_material.assign(mesh.triangles.size(), 0);
  b.add(b.prototype(mesh), b.material(wax(0.01f)));
  b.description.instances.back().materials.push_back(b.material(wax(5)));
  const auto snapshot = b.snapshot();
  const auto& member = snapshot->instances[0].body->members[0];
  EXPECT_TRUE(member.room_to_guide);
  EXPECT_TRUE(member.room_for_spheres);
  EXPECT_FALSE(member.media[1]);
}

// Light that leaves a white bowl through its opening is lost and counted, also when a sphere step carries it out.
TEST(Bodies, LightLostBySphereStepsIsCounted) {
  SceneBuilder b;
  Mesh bowl = testing::sphere_mesh(1, 32, false);
  std::erase_if(bowl.triangles, [&](const auto& t) { return bowl.points[t[0]].y > 0.9f; });
  b.add(b.prototype(bowl), b.material(testing::medium_only(1, 0.01f))).add(testing::constant_dome(1, false));
  const RenderRequest request = testing::request_of(&b, testing::look_at({0, 0, 5}, {0, 0, 0}, 24), 64);
  RenderProgress progress;
  const auto film = testing::render(request, &progress);
  const RenderCounters& c = progress.counters;
  EXPECT_GT(c.walk_sphere_steps, 0u);
  EXPECT_GT(c.walk_lost, 0u);
  EXPECT_EQ(c.nonfinite_samples, 0u);
  // White: a walk leaves through the surface or through the opening, or roulette ends what its weights have thinned
  // out.
  EXPECT_NEAR(c.walk_lost_energy / static_cast<double>(c.walk_lost), 1, 0.1);
}

}  // namespace
}  // namespace alabaster
