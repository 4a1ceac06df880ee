// Clear bodies that touch bodies in which light scatters: light enters below glass and leaves to air, or the reverse.
#include <gtest/gtest.h>

#include <cmath>

#include "testenv/support/furnace.h"
#include "testenv/support/mesh_bodies.h"

namespace alabaster {
namespace {

using testing::add;
using testing::clear_body;
using testing::expect_furnace;
using testing::FurnaceTest;
using testing::moved_by;
using testing::PathTracer;
using testing::RunningStatistics;
using testing::scaled_by;
using testing::SceneBuilder;
using testing::Sight;
using testing::white_body;

/// A ball of radius 1 about the origin, and one of radius .5 that is half sunk into it, at z = 1.
void add_pair(SceneBuilder* b, const DisneyParameters& large, const DisneyParameters& small) {
  const auto ball = b->prototype(testing::sphere_mesh(1, 64, true));
  add(b, ball, large);
  add(b, ball, small, scaled_by(0.5) * moved_by(0, 0, 0.9));
}

const std::vector<Sight> kSights = {{"through the small ball", {0.05, 0.1, 5}, {0.05, 0.1, 1}},
                                    {"its rim", {0, 0, 5}, {0.35, 0, 1}},
                                    {"the ring beside it", {0, 0, 5}, {0.55, 0, 0.8}},
                                    {"the far side", {0.5, 0.5, -5}, {0.1, 0.2, 0}}};

TEST(TouchingBodies, DropOnABodyLosesNoLight) {
  for (const float ior : {1.1f, 1.33f, 1.5f, 2.4f})
    for (const float distance : {0.1f, 0.4f}) {
      SceneBuilder b;
      add_pair(&b, white_body(distance), clear_body(ior));
      expect_furnace(b, kSights, {.runs = 32, .sees_background = true},
                     "index " + std::to_string(ior) + ", distance " + std::to_string(distance));
    }
}

TEST(TouchingBodies, EverySubsurfaceModeLosesNoLight) {
  SceneBuilder b;
  add_pair(&b, white_body(0.3f), clear_body(1.5f));
  expect_furnace(b, kSights, {.mode = SubsurfaceMode::reference, .runs = 32, .sees_background = true}, "drop");
  SceneBuilder small;  // a profile is of a plane
  add_pair(&small, white_body(0.02f), clear_body(1.5f));
  expect_furnace(small, {kSights[0], kSights[2]},
                 {.mode = SubsurfaceMode::diffusion, .runs = 64, .slack = 0.02, .sees_background = true}, "drop");
}

TEST(TouchingBodies, BodyHalfInGlassLosesNoLight) {
  SceneBuilder b;
  add_pair(&b, clear_body(1.5f), white_body(0.3f));
  expect_furnace(b, kSights, {.runs = 64, .sees_background = true}, "half in glass");
  SceneBuilder within;
  const auto ball = within.prototype(testing::sphere_mesh(1, 64, true));
  add(&within, ball, clear_body(1.5f));
  add(&within, ball, white_body(0.3f), scaled_by(0.5));
  expect_furnace(within, {{"middle", {0.1, 0, 5}}, {"rim", {0, 0, 5}, {0.6, 0, 0}}},
                 {.runs = 32, .sees_background = true}, "wholly in glass");
}

/// Priorities of the large and the small one.
struct Priorities {
  uint32_t large, small;
};

TEST(TouchingBodies, CloudyBodiesOfAnyPriorityLoseNoLight) {
  for (const Priorities& of : {Priorities{0, 0}, {1, 0}, {0, 1}}) {
    const std::string which = "priorities " + std::to_string(of.large) + ", " + std::to_string(of.small) + ": ";
    DisneyParameters cloudy = clear_body(1.5f, 0.3f), drop = clear_body(1.33f), milk = clear_body(1.4f, 0.1f);
    cloudy.priority = of.large;
    drop.priority = milk.priority = of.small;
    const FurnaceTest test{.runs = 32, .slack = 4e-3, .sees_background = true};
    SceneBuilder clear_drop, cloudy_drop, opaque_drop;
    add_pair(&clear_drop, cloudy, drop);
    expect_furnace(clear_drop, kSights, test, which + "a clear drop");
    add_pair(&cloudy_drop, cloudy, milk);
    expect_furnace(cloudy_drop, kSights, test, which + "a cloudy drop");
    add_pair(&opaque_drop, cloudy, white_body(0.2f));
    expect_furnace(opaque_drop, kSights, test, which + "an opaque ball");
  }
}

// The lobes of a blend take part. Without retro-reflection they keep back up to 1/42.
TEST(TouchingBodies, BlendOfEntryAndClearBoundaryLosesNoLight) {
  DisneyParameters blend = white_body(0.3f);
  blend.spec_trans = 0.5f;
  blend.ior = 1.4f;
  blend.roughness = 0;
  SceneBuilder b;
  add_pair(&b, blend, clear_body(1.5f));
  std::vector<Sight> sights = kSights;
  for (Sight& sight : sights) sight.level = 0.988;
  expect_furnace(b, sights, {.runs = 32, .slack = 0.013, .sees_background = true}, "blend");
}

// A drop on wax without a walk: below the drop wax is as bright as it is without it, where nothing is refracted.
TEST(TouchingBodies, DropOnADiffuselyTransmittingSolidLosesNoLight) {
  double level[2];
  for (const float ior : {1.00005f, 1.5f}) {
    DisneyParameters wax = white_body(0);
    wax.diff_trans = 1;
    SceneBuilder b;
    add_pair(&b, wax, clear_body(ior));
    b.add(testing::constant_dome(1, true));
    PathTracer tracer(b.snapshot(), kSights[0].eye, kSights[0].target);
    tracer.settings.max_depth = 256;
    level[ior > 1.1f] = testing::look(&tracer, 128, [](const FilmSample& s) { return double(s.color.g); }).mean();
  }
  EXPECT_NEAR(level[1] / level[0], 1, 0.06);  // the drop shades nothing, and reflects
}

// Two drops that overlap, on a body that is a union.
TEST(TouchingBodies, UnionsAndSeveralDropsLoseNoLight) {
  SceneBuilder b;
  const auto ball = b.prototype(testing::sphere_mesh(1, 64, true));
  add(&b, ball, white_body(0.3f), Matrix4d(), "one");
  add(&b, ball, white_body(0.1f), scaled_by(0.6) * moved_by(0.7, 0.3, 0), "one");
  add(&b, ball, clear_body(1.33f), scaled_by(0.5) * moved_by(0, 0, 0.9));
  add(&b, ball, clear_body(1.6f), scaled_by(0.3) * moved_by(0.4, 0, 0.9));
  expect_furnace(b, kSights, {.runs = 64, .sees_background = true}, "two drops");
}

// A drop wholly inside is not seen. A camera in it sees radiance in its medium, which is n^2 times that in air.
TEST(TouchingBodies, DropWhollyInsideIsNotSeen) {
  SceneBuilder b;
  const auto ball = b.prototype(testing::sphere_mesh(1, 64, true));
  add(&b, ball, white_body(0.3f));
  add(&b, ball, clear_body(1.5f), scaled_by(0.3) * moved_by(0.1, 0, 0.3));
  expect_furnace(b, {{"outside", {0, 0, 5}}, {"in the drop", {0.1, 0, 0.25}, {0, 0.1, 0.2}, 2.25}},
                 {.runs = 64, .sees_background = true}, "wholly inside");
}

// Two boxes share a face: a ray that leaves the one goes on behind the face of the other. The camera sees that face
// between two clear bodies, and a drop that lies flat on a cloudy block.
TEST(TouchingBodies, CoincidentFacesLoseNoLight) {
  struct Pair {
    const char* what;
    DisneyParameters left, right;
  };
  DisneyParameters prior = clear_body(1.5f);
  prior.priority = 1;
  const Pair pairs[] = {{"of one index", clear_body(1.5f), clear_body(1.5f)},
                        {"of two", clear_body(1.33f), clear_body(1.5f)},
                        {"of two priorities", clear_body(1.33f), prior},
                        {"clear and cloudy", clear_body(1.33f), clear_body(1.5f, 0.3f)},
                        {"cloudy", clear_body(1.5f, 0.3f), clear_body(1.5f, 0.3f)},
                        {"clear and opaque", clear_body(1.5f), white_body(0.3f)},
                        {"clear and painted", clear_body(1.5f), white_body(0)},
                        {"cloudy and painted", clear_body(1.5f, 0.3f), white_body(0)}};
  for (const Pair& of : pairs) {
    SceneBuilder b;
    const auto box = b.prototype(testing::box_mesh({0.7f, 0.8f, 0.6f}));
    add(&b, box, of.left, moved_by(-0.7, 0, 0));
    add(&b, box, of.right, moved_by(0.7, 0, 0));
    expect_furnace(b,
                   {{"near the face", {1, 2, 5}, {0.1, 0.1, 0}},
                    {"through the face", {-5, 1.5, 3}, {0, 0.05, 0.02}},
                    {"aside", {5, 2, 4}, {0.9, 0.3, 0.2}}},
                   {.runs = 64, .slack = 4e-3, .sees_background = true}, of.what);
  }
}

// Glass on an opaque face looks as if it were sunk into the body by a thousandth, also where rounding leaves a gap:
// behind the face of the glass a ray would be inside the opaque body.
TEST(TouchingBodies, AnOpaqueFaceIsMetBeforeAClearOneThatCoincides) {
  DisneyParameters metal = white_body(0);
  metal.metallic = 1;
  metal.base_color = Rgb(0.9f);
  for (const DisneyParameters& face : {white_body(0), metal, white_body(0.3f)}) {
    const auto seen = [&](double z) {
      SceneBuilder b;
      const auto box = b.prototype(testing::box_mesh({0.7f, 0.8f, 0.6f}));
      add(&b, box, face, moved_by(0, 0, -0.6));
      add(&b, box, clear_body(1.5f), moved_by(0, 0, z));
      b.add(testing::constant_dome(1, true));
      PathTracer tracer(b.snapshot(), {1, 2, 5}, {0.1, 0.1, 0.3});
      tracer.settings.max_depth = 64;
      return testing::look(&tracer, 64, [](const FilmSample& s) { return double(s.color.g); });
    };
    const RunningStatistics sunk = seen(0.599);
    for (const double gap : {0.0, 5e-7})
      EXPECT_TRUE(plausible(z_test(seen(0.6 + gap), sunk, {.slack = 5e-3})))
          << "metallic " << face.metallic << ", distance " << face.scatter_distance.g << ", gap " << gap;
  }
}

// Holes that lie on glass lead into the air of the body, and its wall into the medium, whichever of two faces that
// coincide a ray finds first: that depends on the order of the bodies, and on rounding.
TEST(TouchingBodies, AWallWithHolesOnGlassIsTheSameInAnyOrder) {
  DisneyParameters holed = clear_body(1.5f, 0.2f);
  holed.base_color = Rgb(0.5f);
  holed.opacity = 0.5f;
  const auto seen = [&](bool is_first, double gap) {
    SceneBuilder b;
    const auto box = b.prototype(testing::box_mesh({0.7f, 0.8f, 0.6f}));
    if (is_first) add(&b, box, holed, moved_by(0, 0, -0.6));
    add(&b, box, clear_body(1.5f), moved_by(0, 0, 0.6 + gap));
    if (!is_first) add(&b, box, holed, moved_by(0, 0, -0.6));
    b.add(testing::constant_dome(1, true));
    PathTracer tracer(b.snapshot(), {1.2, 1.4, 5}, {0, 0, 0});
    tracer.settings.max_depth = 256;
    return testing::look(&tracer, 256, [](const FilmSample& s) { return double(s.color.g); });
  };
  const RunningStatistics first = seen(true, 0);
  EXPECT_TRUE(testing::plausible(testing::z_test(seen(false, 0), first)));
  for (const double gap : {-3e-8, 3e-8})
    EXPECT_TRUE(testing::plausible(testing::z_test(seen(true, gap), first))) << "gap " << gap;
}

// A face that is turned and moved coincides but for rounding.
TEST(TouchingBodies, NearlyCoincidentFacesLoseNoLight) {
  SceneBuilder b;
  const Matrix4d turn = Matrix4d().setAxisAngle(normalize(Vec3d(1, 2, 3)), 0.7) * moved_by(0.3, -0.2, 0.1);
  add(&b, b.prototype(testing::box_mesh({0.7f, 0.8f, 0.6f})), clear_body(1.5f), moved_by(-0.7, 0, 0) * turn);
  add(&b, b.prototype(testing::box_mesh({1, 1, 1})), clear_body(1.4f),
      Matrix4d().setScale(Vec3d(0.3, 0.8, 0.6)) * moved_by(0.3, 0, 0) * turn);
  expect_furnace(
      b, {{"near the face", {1, 2, 5}, {0.35, -0.15, 0.1}}, {"through the face", {-5, 1.5, 3}, {0.3, -0.2, 0.1}}},
      {.runs = 64, .slack = 4e-3, .sees_background = true}, "turned");
}

// A member of a union that lies in another one changes nothing: a ray that has entered a cloudy body, and meets the
// member's wall, walks on from where it entered.
TEST(TouchingBodies, AMemberWhollyWithinAnotherChangesNothing) {
  const auto green = [](const FilmSample& s) { return double(s.color.g); };
  RunningStatistics seen[2];
  for (const bool has_member : {false, true}) {
    SceneBuilder b;
    DisneyParameters cloudy = clear_body(1.3f, 1.0f);
    cloudy.base_color = Rgb(0.5f);
    const auto ball = b.prototype(testing::sphere_mesh(1, 64, true));
    add(&b, ball, cloudy, Matrix4d(), "one");
    if (has_member) add(&b, ball, cloudy, scaled_by(0.9), "one");
    b.add(testing::constant_dome(1, true));
    PathTracer tracer(b.snapshot(), {0.5, 0.7, 5}, {0.1, 0.2, 0});
    seen[has_member] = testing::look(&tracer, 256, green);
  }
  EXPECT_TRUE(plausible(z_test(seen[1], seen[0])));
}

// Many drops are an array of instances.
TEST(TouchingBodies, DropsOfAnInstanceArrayLoseNoLight) {
  SceneBuilder b;
  const auto ball = b.prototype(testing::sphere_mesh(1, 64, true));
  add(&b, ball, white_body(0.3f));
  add(&b, ball, clear_body(1.5f));
  std::vector<Matrix4d> places;
  for (int i = 0; i < 4; ++i) places.push_back(scaled_by(0.3) * moved_by(0.35 * (i & 1), 0.35 * (i >> 1), 0.9));
  testing::make_last_an_array(&b, std::move(places));
  expect_furnace(b, kSights, {.runs = 64, .sees_background = true}, "an array of drops");
}

// A lamp beside a drop: shortcuts change noise only.
TEST(TouchingBodies, WalkAndReferenceAgreeUnderALamp) {
  SceneBuilder b;
  DisneyParameters skin = white_body(0.3f);
  skin.base_color = Rgb(0.8f);
  add_pair(&b, skin, clear_body(1.5f));
  LightParameters lamp;
  lamp.type = LightType::sphere;
  lamp.radius = 0.3f;
  lamp.intensity = 50;
  lamp.light_to_world = moved_by(3, 1, 1);
  b.add(lamp);
  const auto scene = b.snapshot();
  const auto green = [](const FilmSample& s) { return double(s.color.g); };
  for (const Sight& sight : kSights) {
    PathTracer walk(scene, sight.eye, sight.target), reference(scene, sight.eye, sight.target);
    reference.settings.subsurface = SubsurfaceMode::reference;
    reference.settings.walk.guiding = reference.settings.walk.sphere_steps = reference.settings.walk.twins = false;
    const auto a = testing::look(&walk, 128, green), r = testing::look(&reference, 128, green);
    EXPECT_GT(r.mean(), 1e-4);
    EXPECT_TRUE(plausible(z_test(a, r))) << sight.what;
  }
}

}  // namespace
}  // namespace alabaster
