// Walks without an entry lobe (rays that begin within a medium), and holes of bodies.
#include "core/integrator/subsurface_scatter.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/integrator/interface.h"
#include "testenv/support/furnace.h"
#include "testenv/support/material_testing.h"
#include "testenv/support/memory_texture.h"
#include "testenv/support/mesh_bodies.h"

namespace alabaster {
namespace {

using testing::add;
using testing::clear_body;
using testing::expect_furnace;
using testing::FurnaceTest;
using testing::moved_by;
using testing::PathTracer;
using testing::scaled_by;
using testing::SceneBuilder;
using testing::Sight;
using testing::white_body;

TEST(EntryWithoutASurface, AWhiteBodyIsWhiteFromWithin) {
  for (const float roughness : {0.0f, 1.0f}) {
    SceneBuilder b;
    DisneyParameters p = white_body(0.3f);
    p.roughness = roughness;
    add(&b, b.prototype(testing::sphere_mesh(1, 32, true)), p);
    for (const auto mode : {SubsurfaceMode::walk, SubsurfaceMode::reference})
      expect_furnace(b, {{"middle", {0, 0, 0.5}}, {"rim", {0.1, 0.9, 0}}}, {.mode = mode}, "one body");
  }
}

TEST(EntryWithoutASurface, BodiesWithinBodiesLoseNothing) {
  SceneBuilder b;
  const auto ball = b.prototype(testing::sphere_mesh(1, 32, true));
  add(&b, ball, white_body(0.2f));
  add(&b, ball, white_body(0.5f), scaled_by(2) * moved_by(0, 0, 0.3));
  expect_furnace(b, {{"inner", {0, 0, 0.5}}, {"off the middle", {0.3, 0.2, 0.1}}, {"outside", {0, 0, 4}}}, {},
                 "nested");
}

TEST(EntryWithoutASurface, BoxesThatTouchLoseNothing) {
  SceneBuilder b;
  const auto box = b.prototype(testing::box_mesh({0.5f, 0.5f, 0.5f}));
  add(&b, box, white_body(0.3f), moved_by(-0.5, 0, 0));
  add(&b, box, white_body(0.6f), moved_by(0.5, 0, 0));
  expect_furnace(b,
                 {{"beside the seam", {0.06, 0.1, 3}, {0.05, 0.1, 0.5}},
                  {"a side", {-0.3, 0.2, 3}, {-0.3, 0.2, 0.5}},
                  {"the top", {0.1, 3, 1}, {0.1, 0.5, 0.1}}},
                 {.runs = 128}, "side by side");
}

// A union contains a ray's origin by the crossings of the whole line. Up to the first surface alone, rounding would
// decide if that surface counts.
TEST(EntryWithoutASurface, ARayMayBeginWithinAUnion) {
  SceneBuilder b;
  const auto ball = b.prototype(testing::sphere_mesh(1, 24, true));
  add(&b, ball, white_body(0.3f), Matrix4d(), "one");
  add(&b, ball, white_body(0.1f), scaled_by(0.8) * moved_by(0.7, 0.3, 0.2), "one");
  std::vector<Sight> sights;
  for (int i = 0; i < 12; ++i) {
    const double angle = 0.5 * i;
    sights.push_back({"about the middle", {0.61 * std::cos(angle), 0.2, 0.53 * std::sin(angle)}});
  }
  expect_furnace(b, sights, {.runs = 16}, "a union");
}

// A camera's far plane may lie within a clear body.
TEST(EntryWithoutASurface, InteriorsAreFoundBeyondTheReachOfARay) {
  SceneBuilder b;
  add(&b, b.prototype(testing::sphere_mesh(10, 16, true)), clear_body(1.33f));
  PathTracer tracer(b.snapshot(), {0, 0, 1});
  EXPECT_EQ(interiors_at(tracer.context(), {{0, 0, 0}, {0, 0, 1}, 1}, Seeker::camera).index(), 1.33f);
}

// Light that leaves by the exit lobe and by the clear share has the same weight, however it entered.
TEST(EntryWithoutASurface, ABlendOfEntryAndClearBoundaryLosesNothing) {
  for (const float clear_share : {0.25f, 0.75f}) {
    SceneBuilder b;
    DisneyParameters p = white_body(0.5f);
    p.spec_trans = clear_share;
    p.ior = 1.00005f;  // no reflection, which the base would have to leave out
    add(&b, b.prototype(testing::sphere_mesh(1, 48, true)), p);
    expect_furnace(b, {{"outside", {0, 0, 4}}, {"inside", {0, 0.4, 0}}}, {}, "a blend");
  }
}

// Layers let a white body look as bright to a camera within it as they let it look from outside.
TEST(EntryWithoutASurface, LayersKeepNoMoreFromWithinThanFromOutside) {
  for (const bool coated : {true, false}) {
    SceneBuilder b;
    DisneyParameters p = white_body(0.2f);
    p.coat = coated ? 1.0f : 0.0f, p.sheen = coated ? 0.0f : 1.0f;
    p.coat_roughness = 0.3f, p.sheen_roughness = 0.5f;
    add(&b, b.prototype(testing::sphere_mesh(1, 32, true)), p);
    b.add(testing::constant_dome(1, true));
    const auto scene = b.snapshot();
    PathTracer within(scene, {0.3, 0.2, 0.1}, {0, 0, 1}), outside(scene, {0, 0, 5}, {0.1, 0.2, 0});
    const auto green = [](const FilmSample& s) { return double(s.color.g); };
    EXPECT_GT(testing::look(&within, 128, green).mean(), testing::look(&outside, 128, green).mean() - 0.03) << coated;
  }
}

// Short walks in a union come out as Lambert's law has it: the way from the surface to where a walk begins counts.
TEST(Union, SmallScatterDistancesAreLambert) {
  testing::RunningStatistics seen[2];
  for (const bool walks : {false, true}) {
    SceneBuilder b;
    const auto ball = b.prototype(testing::sphere_mesh(1, 32, true));
    DisneyParameters p = white_body(6e-5f);
    p.base_color = Rgb(0.6f);
    add(&b, ball, p, Matrix4d(), "one");
    add(&b, ball, p, scaled_by(0.6) * moved_by(1.2, 0.4, 0.3), "one");
    b.add(testing::constant_dome(1, false));
    PathTracer tracer(b.snapshot(), {0.4, 0.2, 5}, {0.1, 0.1, 0});
    tracer.settings.subsurface = walks ? SubsurfaceMode::walk : SubsurfaceMode::lambert;
    seen[walks] = testing::look(&tracer, 1024, [](const FilmSample& s) { return double(s.color.g); });
    EXPECT_EQ(tracer.counters.walk_lost, 0u);
  }
  EXPECT_TRUE(plausible(z_test(seen[1], seen[0], {.slack = 2e-3 * seen[0].mean()})));
}

constexpr SubsurfaceMode kModes[] = {SubsurfaceMode::lambert, SubsurfaceMode::walk, SubsurfaceMode::reference,
                                     SubsurfaceMode::diffusion};

// Two walls of opacity .5 are seen with alpha .75. A ray that passes the first meets the other from inside, through
// air.
TEST(Holes, AHalfOpaqueBodyIsAsBrightAsItCovers) {
  SceneBuilder b;
  DisneyParameters p = white_body(0.2f);
  p.opacity = 0.5f;
  add(&b, b.prototype(testing::sphere_mesh(1, 32, true)), p);
  for (const auto mode : kModes)
    expect_furnace(b, {{"middle", {0.3, 0.2, 4}, {0.06, 0.07, 0}, 0.75}, {"rim", {0.1, 0.3, 4}, {0.77, 0.13, 0}, 0.75}},
                   {.mode = mode, .runs = 256, .slack = 4e-3}, "a ball");
}

TEST(Holes, SurfacesAboutABodyWithHolesLoseNothing) {
  for (const float distance : {0.02f, 0.5f}) {
    SceneBuilder b;
    DisneyParameters p = white_body(distance), floor = white_body(0);
    p.opacity = 0.5f;
    floor.scatter_distance = Rgb(0.0f);
    add(&b, b.prototype(testing::sphere_mesh(1, 32, true)), p);
    add(&b, b.prototype(testing::plane_mesh(40)), floor, moved_by(0, -1, 0));
    expect_furnace(b, {{"the floor", {3, 3, 3}, {0.7, -1, 0.7}}}, {.runs = 128, .slack = 3e-3}, "beside it");
  }
}

// Cut-outs by a texture, on an instance that is stretched.
TEST(Holes, CutOutsShowTheInside) {
  SceneBuilder b;
  Mesh ball = testing::sphere_mesh(1, 32, true);
  ball.uv_sets.push_back({{}, "st"});
  for (const Vec3f& p : ball.points) ball.uv_sets[0].values.emplace_back(2 * p.x + 1.3f * p.z, 0);
  auto material = std::make_shared<DisneyMaterial>();
  material->constants = white_body(0.3f);
  testing::connect("opacity", std::make_shared<testing::MemoryTexture>(2, std::vector<Rgb>{Rgb(0.0f), Rgb(1.0f)}),
                   material.get(), Channel::r);
  material->constants.opacity_threshold = 0.5f;
  b.add(b.prototype(std::move(ball)), material, Matrix4d().setScale(Vec3d(1, 1.5, 0.7)));
  for (const auto mode : {SubsurfaceMode::walk, SubsurfaceMode::diffusion})
    expect_furnace(b,
                   {{"a hole", {0.2, 0, 4}, {0.12, 0, 0}},
                    {"aside", {0.5, 1, 4}, {0.3, 0.2, 0}},
                    {"below", {-0.3, 0.1, -4}, {0, 0.1, 0}}},
                   {.mode = mode, .runs = 128, .slack = 4e-3, .sees_background = true}, "cut out");
}

TEST(Holes, MembersOfAUnionMayHaveHoles) {
  SceneBuilder b;
  const auto ball = b.prototype(testing::sphere_mesh(1, 32, true));
  DisneyParameters p = white_body(0.2f);
  add(&b, ball, p, Matrix4d(), "one");
  p.opacity = 0.5f;
  add(&b, ball, p, moved_by(1, 0.2, 0.4), "one");
  expect_furnace(b,
                 {{"the one with holes", {1.5, 0.3, 6}, {1.5, 0.3, 0}},
                  {"before the other", {0.6, 0.1, 6}, {0.5, 0.1, 0}},
                  {"the other", {-0.5, 0, 6}, {-0.5, 0, 0}}},
                 {.runs = 128, .slack = 3e-3, .sees_background = true}, "a union");
}

// Light within the medium of a union passes the walls of all members, and sees no holes in them.
TEST(Holes, MembersOfACloudyUnionMayHaveHoles) {
  SceneBuilder b;
  const auto ball = b.prototype(testing::sphere_mesh(1, 48, true));
  DisneyParameters p = clear_body(1.5f, 0.4f);
  p.opacity = 0.5f;
  add(&b, ball, p, Matrix4d(), "one");
  add(&b, ball, p, scaled_by(0.6) * moved_by(-0.5, -0.45, 0.55), "one");
  expect_furnace(b,
                 {{"where they overlap", {1.2, 2.4, 8}, {-0.4, -0.4, 0.6}},
                  {"the small one", {0, 0, 8}, {-0.85, -0.7, 0.6}},
                  {"the large one", {0, 0, 8}, {0.5, 0.3, 0}}},
                 {.runs = 256, .slack = 3e-3, .sees_background = true}, "a cloudy union");
}

// A member within another one, and two that overlap: a ray passes two walls, whatever it meets within.
TEST(Holes, WallsWithinAUnionAreNotThere) {
  for (const Matrix4d& place : {scaled_by(0.5), moved_by(0.9, 0.2, 0.4)}) {
    SceneBuilder b;
    const auto ball = b.prototype(testing::sphere_mesh(1, 32, true));
    DisneyParameters p = white_body(0.2f);
    p.opacity = 0.5f;
    add(&b, ball, p, Matrix4d(), "one");
    add(&b, ball, p, place, "one");
    for (const auto mode : kModes)
      expect_furnace(b, {{"through both", {0.23, 0.12, 6}, {0.23, 0.12, 0}, 0.75}},
                     {.mode = mode, .runs = 256, .slack = 4e-3}, "a union");

    // Shadows.
    b.add(b.prototype(testing::plane_mesh(9)), b.material(testing::matt(Rgb(0.8f))),
          Matrix4d().setAxisAngle(Vec3d(1, 0, 0), M_PI / 2) * moved_by(0.23, 0.12, -3));
    LightParameters sun;
    sun.type = LightType::distant;
    sun.angle = 0;
    b.add(sun);
    const auto floor_from = [&] {
      PathTracer tracer(b.snapshot(), {4, 0.12, -1}, {0.23, 0.12, -3});
      tracer.settings.max_depth = 1;
      return tracer.trace(0).color.g;
    };
    const float shaded = floor_from();
    b.description.instances.erase(b.description.instances.begin(), b.description.instances.begin() + 2);
    EXPECT_NEAR(shaded / floor_from(), 0.25f, 1e-6f);
  }
}

TEST(Holes, ClearAndCloudyBodiesMayHaveHoles) {
  for (const float scatter_distance : {0.0f, 0.3f})
    for (const float clear_share : {1.0f, 0.5f}) {
      SceneBuilder b;
      DisneyParameters p = clear_body(1.5f, scatter_distance);
      p.spec_trans = clear_share;
      p.specular = clear_share == 1 ? 1 : 0;
      p.roughness = clear_share == 1 ? 0 : 0.5f;
      if (clear_share < 1) p.ior = 1.00005f;  // rough facets would lose light
      p.opacity = 0.5f;
      add(&b, b.prototype(testing::sphere_mesh(1, 48, true)), p);
      for (const auto mode : {SubsurfaceMode::lambert, SubsurfaceMode::walk})
        expect_furnace(b, {{"middle", {0.1, 0.2, 4}, {0.06, 0.07, 0}}, {"rim", {0.1, 0.3, 4}, {0.67, 0.13, 0}}},
                       {.mode = mode, .runs = 128, .slack = 4e-3, .sees_background = true},
                       "clear share " + std::to_string(clear_share));
    }
}

// A lamp that shines through holes: shortcuts change noise only.
TEST(Holes, WalkAndReferenceAgreeUnderALamp) {
  SceneBuilder b;
  DisneyParameters p = white_body(0.3f);
  p.base_color = Rgb(0.8f);
  p.opacity = 0.6f;
  add(&b, b.prototype(testing::sphere_mesh(1, 32, true)), p);
  LightParameters lamp;
  lamp.type = LightType::sphere;
  lamp.radius = 0.3f;
  lamp.intensity = 50;
  lamp.light_to_world = moved_by(1, 2, -2);
  b.add(lamp);
  const auto scene = b.snapshot();
  PathTracer walk(scene, {0, 0, 4}), reference(scene, {0, 0, 4});
  reference.settings.subsurface = SubsurfaceMode::reference;
  reference.settings.walk.guiding = reference.settings.walk.sphere_steps = reference.settings.walk.twins = false;
  const auto green = [](const FilmSample& s) { return double(s.color.g); };
  const auto a = testing::look(&walk, 256, green), r = testing::look(&reference, 256, green);
  EXPECT_GT(r.mean(), 0.01);
  EXPECT_TRUE(plausible(z_test(a, r)));
}

}  // namespace
}  // namespace alabaster
