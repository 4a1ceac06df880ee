// What stands in a body that scatters, and opaque faces of its own.
#include <gtest/gtest.h>

#include <cmath>

#include "testenv/support/furnace.h"
#include "testenv/support/medium_bodies.h"
#include "testenv/support/mesh_bodies.h"

namespace alabaster {
namespace {

using testing::add;
using testing::clear_body;
using testing::expect_furnace;
using testing::FurnaceTest;
using testing::matt;
using testing::moved_by;
using testing::PathTracer;
using testing::scaled_by;
using testing::SceneBuilder;
using testing::Sight;
using testing::white_body;

const std::vector<Sight> kSights = {{"towards it", {0, 0, 5}, {0.15, 0.1, 0}}, {"beside it", {0, 0, 5}, {-0.6, 0, 0}}};

/// A ball of radius 1 about the origin, and one of .4 within.
SceneBuilder ball_with(const DisneyParameters& body, const DisneyParameters& content) {
  SceneBuilder b;
  const auto ball = b.prototype(testing::sphere_mesh(1, 48, true));
  add(&b, ball, body);
  add(&b, ball, content, scaled_by(0.4) * moved_by(0.2, 0.1, 0.1));
  return b;
}

testing::RunningStatistics seen(const SceneBuilder& builder, const Sight& sight, int runs,
                                SubsurfaceMode mode = SubsurfaceMode::walk) {
  SceneBuilder b = builder;
  b.add(testing::constant_dome(1, true));
  PathTracer tracer(b.snapshot(), sight.eye, sight.target);
  tracer.settings.max_depth = 256;
  if (mode == SubsurfaceMode::reference)
    tracer.settings.walk = {.guiding = false, .sphere_steps = false, .twins = false};
  return testing::look(&tracer, runs, [](const FilmSample& s) { return double(s.color.g); });
}

TEST(Contents, WhiteOnesLoseNoLight) {
  DisneyParameters metal = clear_body(1.5f);
  metal.spec_trans = 0, metal.metallic = 1;
  DisneyParameters hull = clear_body(1.5f, 0.05f), with_holes = clear_body(1.5f);
  with_holes.opacity = 0.5f;
  for (const float ior : {1.0f, 1.33f})
    for (const auto& [content, what] : {std::pair(white_body(0), "matt"),
                                        {metal, "metal"},
                                        {clear_body(1.5f), "glass"},
                                        {with_holes, "glass with holes"},
                                        {white_body(0.05f), "wax"},
                                        {hull, "cloudy"}})
      expect_furnace(ball_with(clear_body(ior, 0.2f), content), kSights, {.runs = 32, .sees_background = true},
                     std::string(what) + " in index " + std::to_string(ior));
}

// Light goes in through one member and comes out of another one, whichever has the higher priority.
TEST(Contents, InAUnionLoseNoLight) {
  for (const uint32_t priority : {0u, 1u, 2u}) {
    DisneyParameters milk = clear_body(1.33f, 0.2f), other = milk;
    milk.priority = 1, other.priority = priority;
    SceneBuilder b;
    const auto ball = b.prototype(testing::sphere_mesh(1, 48, true));
    add(&b, ball, milk, Matrix4d(), "milk");
    add(&b, ball, other, scaled_by(0.8) * moved_by(0.5, 0.2, 0.6), "milk");
    add(&b, ball, white_body(0), scaled_by(0.3) * moved_by(0.2, 0.1, 0.1));
    expect_furnace(b, kSights, {.runs = 64, .sees_background = true}, "priority " + std::to_string(priority));
  }
}

// As it is just above the wall, whichever of the two a walk meets first.
TEST(Contents, AGlowingPlateOnTheWallIsSeen) {
  DisneyParameters glow = matt(Rgb(0.5f));
  glow.emission = Rgb(4.0f);
  const auto at = [&](double z) {
    SceneBuilder b;
    add(&b, b.prototype(testing::box_mesh({0.7f, 0.8f, 0.6f})), clear_body(1.33f, 0.3f));
    add(&b, b.prototype(testing::box_mesh({0.6f, 0.6f, 0.1f})), glow, moved_by(0, 0, z));
    return seen(b, {"", {1, 2, 5}, {0.1, 0.1, 0}}, 128);
  };
  const auto sunk = at(-0.699);
  for (const double gap : {0.0, 5e-7})
    EXPECT_TRUE(testing::plausible(testing::z_test(at(-0.7 - gap), sunk, {.slack = 0.01 * sunk.mean()})))
        << "gap " << gap;
  EXPECT_GT(sunk.mean(), 1.1);
}

// Walks meet both, those that enter by a lobe as well as those behind a clear wall.
TEST(Contents, ALampIsAsBrightAsAMeshThatEmits) {
  for (const float spec_trans : {0.5f, 1.0f}) {
    DisneyParameters body = clear_body(1.5f, 0.3f);
    body.spec_trans = spec_trans;
    DisneyParameters glow = matt(Rgb(0.0f));
    const float radiance = 10;
    glow.emission = Rgb(radiance);
    SceneBuilder lamp = ball_with(body, matt(Rgb(0.0f)));
    LightParameters light;
    light.type = LightType::sphere;
    light.radius = 0.401f;
    light.intensity = radiance;
    light.light_to_world = moved_by(0.2, 0.1, 0.1);
    lamp.add(light);
    for (const Sight& sight : kSights) {
      const auto mesh = seen(ball_with(body, glow), sight, 128);
      EXPECT_TRUE(testing::plausible(testing::z_test(seen(lamp, sight, 128), mesh, {.slack = 0.01 * mesh.mean()})))
          << "specTrans " << spec_trans << ", " << sight.what;
    }
  }
}

// Nor does light that leaves by a lobe go into an opaque one that lies on the wall.
TEST(Contents, AMirrorOnAPartlyClearWallLosesNoLight) {
  DisneyParameters mirror = white_body(0), body = white_body(0.2f);
  mirror.metallic = 1, mirror.roughness = 0;
  body.spec_trans = 0.3f, body.ior = 1;
  SceneBuilder b;
  add(&b, b.prototype(testing::box_mesh({-0.9f, -0.6f, -0.6f}, {0.9f, 0.6f, 0.6f})), body);
  add(&b, b.prototype(testing::box_mesh({-0.5f, 0.6f, -0.5f}, {0.5f, 0.61f, 0.5f})), mirror);
  expect_furnace(b, {{"beside it", {0, 0, 5}, {0, 0.45, 0.6}}}, {.runs = 128, .sees_background = true}, "mirror");
}

/// A ball of which a third of the faces has another material.
SceneBuilder labelled(const DisneyParameters& body, const DisneyParameters& label, const char* set = "") {
  SceneBuilder b;
  Mesh ball = testing::sphere_mesh(1, 48, true);
  ball.triangle_material.assign(ball.triangles.size(), 0);
  std::fill_n(ball.triangle_material.rbegin(), ball.triangles.size() / 3, 1);
  add(&b, b.prototype(ball), body, Matrix4d(), set);
  b.description.instances.back().materials.push_back(b.material(label));
  return b;
}

// Labels and gilding: on wax and on milk, seen on it, beside it, and from within; with holes, which walks ignore.
TEST(Contents, WhiteFacesOfTheBodyLoseNoLight) {
  DisneyParameters gold = white_body(0), with_holes = white_body(0);
  gold.metallic = 1, gold.roughness = 0;
  with_holes.opacity = 0.5f;
  std::vector<Sight> sights = {{"from -x", {-5, 0.3, 0.2}}, {"from x", {5, 0.2, -0.4}}, {"from y", {0.3, 5, 0.2}}};
  std::vector<Sight> inside = {{"within, to x", {0.1, 0, 0}, {1, 0.2, 0.1}},
                               {"within, to -x", {0.1, 0, 0}, {-1, 0.2, 0.1}}};
  for (const auto& [label, what] : {std::pair(white_body(0), "paper"), {gold, "gold"}, {with_holes, "lace"}}) {
    const FurnaceTest test{.runs = 48, .slack = 4e-3, .sees_background = true};
    expect_furnace(labelled(white_body(0.3f), label), sights, test, std::string(what) + " on wax");
    expect_furnace(labelled(white_body(0.3f), label), inside, test, std::string(what) + " on wax");
    expect_furnace(labelled(clear_body(1.33f, 0.3f), label), sights, test, std::string(what) + " on milk");
  }
}

// Nor behind an open mesh, where there is no wall ahead. It was a quarter, beside the little that is lost below any
// sheet.
TEST(Contents, ALabelOnASheetLosesNoLight) {
  const auto beside = [](const std::vector<uint8_t>& materials) {
    SceneBuilder b;
    Mesh sheet = testing::plane_mesh(4);
    sheet.triangle_material.assign(materials.begin(), materials.end());
    add(&b, b.prototype(sheet), white_body(0.05f));
    b.description.instances.back().materials.push_back(b.material(white_body(0)));
    return seen(b, {"beside it", {0.05, 3, -0.05}, {0.05, 0, -0.05}}, 64).mean();
  };
  EXPECT_GT(beside({1, 0}), beside({0, 0}) - 0.1);
}

// They let light neither in nor out, at once in a set as alone.
TEST(Contents, LabelsDimTheWaxBesideThem) {
  const Sight beside{"", {-5, 0.3, 0.2}};
  const auto white = seen(labelled(white_body(0.5f), white_body(0)), beside, 64);
  const auto black = seen(labelled(white_body(0.5f), matt(Rgb(0.0f))), beside, 64);
  const auto in_set = seen(labelled(white_body(0.5f), matt(Rgb(0.0f)), "set"), beside, 64);
  EXPECT_LT(black.mean(), white.mean() - 0.05);
  EXPECT_TRUE(testing::plausible(testing::z_test(in_set, black)));
}

// A body that something stands in is the same in an array: a lamp, or opaque faces of its own.
TEST(Contents, OfAnArrayAreThoseOfEachOfItsBodies) {
  for (const bool has_lamp : {true, false}) {
    SceneBuilder alone;
    if (has_lamp)
      add(&alone, alone.prototype(testing::sphere_mesh(1, 48, true)), clear_body(1.33f, 0.3f));
    else
      alone = labelled(clear_body(1.33f, 0.3f), white_body(0));
    LightParameters lamp;
    lamp.type = LightType::sphere;
    lamp.radius = 0.4f;
    lamp.intensity = 10;
    if (has_lamp) alone.add(lamp);
    SceneBuilder in_array = alone;
    testing::make_last_an_array(&in_array, {Matrix4d()});
    const auto a = seen(alone, kSights[1], 64), b = seen(in_array, kSights[1], 64);
    EXPECT_TRUE(testing::plausible(testing::z_test(b, a))) << has_lamp;
    if (has_lamp) continue;
    EXPECT_NEAR(b.mean(), 1, 0.01) << "a white label";
  }
}

TEST(Contents, OneOfTheSameMediumChangesNothing) {
  DisneyParameters milk = clear_body(1.33f, 0.3f);
  milk.base_color = Rgb(0.8f);
  SceneBuilder alone;
  add(&alone, alone.prototype(testing::sphere_mesh(1, 48, true)), milk);
  for (const Sight& sight : kSights) {
    const auto without = seen(alone, sight, 128), with = seen(ball_with(milk, milk), sight, 128);
    EXPECT_TRUE(testing::plausible(testing::z_test(with, without))) << sight.what;
  }
}

DisneyParameters milk() {
  DisneyParameters p = clear_body(1.33f, 0.3f);
  p.base_color = Rgb(0.8f);
  return p;
}

// Of two overlapping balls of milk in a set.
void expect_no_change_by(const DisneyParameters& content, const Matrix4d& place) {
  SceneBuilder b;
  const auto ball = b.prototype(testing::sphere_mesh(1, 48, true));
  add(&b, ball, milk(), Matrix4d(), "milk");
  add(&b, ball, milk(), scaled_by(0.8) * moved_by(0.5, 0.2, 0.6), "milk");
  const Sight sight{"towards both", {0, 0, 5}, {0.5, 0.25, 0.7}};
  const auto without = seen(b, sight, 256);
  add(&b, ball, content, place);
  EXPECT_TRUE(testing::plausible(testing::z_test(seen(b, sight, 256), without)));
}

// A wall between members of a union goes through it.
TEST(Contents, OneBetweenTheMembersOfAUnionChangesNothing) {
  expect_no_change_by(milk(), scaled_by(0.35) * moved_by(0.5, 0.25, 0.7));
}

// Nor is a segment of a path lost up to a wall that another member hides.
TEST(Contents, WithoutAnyAUnionIsAsDenseAsWithAGrain) {
  expect_no_change_by(matt(Rgb(0.0f)), scaled_by(1e-3) * moved_by(-0.8, 0, 0));
}

// What is around it is found behind opaque faces as well.
TEST(Contents, OneOfTheSameMediumInALabelledBodyLosesNoLight) {
  const DisneyParameters milk = clear_body(1.5f, 0.3f);
  Mesh ball = testing::sphere_mesh(1, 48, true);
  SceneBuilder b;
  add(&b, b.prototype(ball), milk, scaled_by(0.4) * moved_by(0.2, 0.1, 0.1));
  ball.triangle_material.assign(ball.triangles.size(), 0);
  std::fill_n(ball.triangle_material.rbegin(), ball.triangles.size() / 2, 1);
  add(&b, b.prototype(ball), milk);
  b.description.instances.back().materials.push_back(b.material(white_body(0)));
  expect_furnace(b, kSights, {.runs = 64, .sees_background = true}, "labelled");
}

void expect_as_faces(const DisneyParameters& body, const DisneyParameters& content, const char* set) {
  SceneBuilder separate = ball_with(body, content), as_faces;
  for (auto& instance : separate.description.instances) instance.subsurface_set = set;
  Mesh ball = testing::sphere_mesh(1, 48, true), inner = ball;
  for (Vec3f& p : inner.points) p = p * 0.4f + Vec3f(0.2f, 0.1f, 0.1f);
  const size_t outer = ball.triangles.size();
  ball = testing::merged(ball, inner);
  ball.normals.clear(), ball.normal_triangles.clear();
  ball.triangle_material.assign(ball.triangles.size(), 1);
  std::fill_n(ball.triangle_material.begin(), outer, 0);
  add(&as_faces, as_faces.prototype(ball), body);
  as_faces.description.instances.back().materials.push_back(as_faces.material(content));
  for (const Sight& sight : kSights) {
    const auto a = seen(separate, sight, 128), b = seen(as_faces, sight, 128);
    EXPECT_TRUE(testing::plausible(testing::z_test(a, b))) << sight.what;
    EXPECT_GT(std::abs(a.mean() - 1), 0.05);
  }
}

TEST(Contents, BlackOneIsTheSameAsOpaqueFacesOfTheBody) {
  expect_as_faces(clear_body(1.33f, 0.3f), matt(Rgb(0.0f)), "");
  expect_as_faces(white_body(0.3f), matt(Rgb(0.0f)), "set");
}

TEST(Contents, GlowingOneIsTheSameAsGlowingFacesOfTheBody) {
  DisneyParameters glow = matt(Rgb(0.0f));
  glow.emission = Rgb(5.0f);
  expect_as_faces(clear_body(1.33f, 0.3f), glow, "");
}

DisneyParameters cloudy(float ior, float emission) {
  DisneyParameters p = clear_body(ior, 0.3f);
  p.subsurface_color = Rgb(0.6f);
  p.emission = Rgb(emission);
  return p;
}

// At index 1 a wall that emits sends inwards what a sky sends through it, and shows it outside, too.
TEST(Contents, AClearWallEmitsInwardsAsASkyShines) {
  for (const bool has_stone : {true, false})
    for (const Sight& sight : kSights) {
      SceneBuilder glowing = ball_with(cloudy(1, 1), matt(Rgb(0.0f))),
                   below_sky = ball_with(cloudy(1, 0), matt(Rgb(0.0f)));
      if (!has_stone) glowing.description.instances.pop_back(), below_sky.description.instances.pop_back();
      below_sky.add(testing::constant_dome(1, true));
      const auto a = seen(glowing, sight, 128), b = seen(below_sky, sight, 128);
      EXPECT_TRUE(testing::plausible(
          testing::z_test(a.mean() - b.mean(), std::hypot(a.standard_error(), b.standard_error()), 1)))
          << sight.what << ", " << has_stone;
    }
}

// Nor is light sampled on a wall that walks meet: rough glass would sample it where nothing stands in the body.
TEST(Contents, AGrainInAGlowingBodyChangesNothing) {
  DisneyParameters body = cloudy(1.33f, 1);
  body.roughness = 0.6f;
  SceneBuilder b;
  const auto ball = b.prototype(testing::sphere_mesh(1, 48, true));
  add(&b, ball, body);
  const auto without = seen(b, kSights[0], 256);
  add(&b, ball, matt(Rgb(0.0f)), scaled_by(1e-3) * moved_by(-0.8, 0, 0));
  EXPECT_TRUE(testing::plausible(testing::z_test(seen(b, kSights[0], 256), without)));
}

// Sphere steps keep clear of what stands within.
TEST(Contents, ShortcutsChangeNothing) {
  DisneyParameters milk = clear_body(1.0f, 0.02f);
  milk.base_color = Rgb(0.98f);
  const SceneBuilder b = ball_with(milk, matt(Rgb(0.0f)));
  for (const Sight& sight : kSights) {
    const auto walk = seen(b, sight, 128), reference = seen(b, sight, 128, SubsurfaceMode::reference);
    EXPECT_TRUE(testing::plausible(testing::z_test(walk, reference, {.slack = 1e-3}))) << sight.what;
  }
}

// Behind diffuse walls walks know their own body alone, but for opaque members of its set.
TEST(Contents, BonesAreWithinTheBodyOfTheirSetAlone) {
  const auto hand = [](const char* set) {
    SceneBuilder b;
    const auto ball = b.prototype(testing::sphere_mesh(1, 48, true));
    add(&b, ball, white_body(1.0f), Matrix4d(), "hand");
    add(&b, ball, matt(Rgb(0.0f)), scaled_by(0.5), set);
    return b;
  };
  EXPECT_NEAR(seen(hand(""), kSights[0], 32).mean(), 1, 0.01);
  EXPECT_LT(seen(hand("hand"), kSights[0], 32).mean(), 0.8);
  SceneBuilder white = hand("hand");
  white.description.instances.back().materials = {white.material(white_body(0))};
  expect_furnace(white, kSights, {.runs = 64, .sees_background = true}, "white bone");
}

}  // namespace
}  // namespace alabaster
