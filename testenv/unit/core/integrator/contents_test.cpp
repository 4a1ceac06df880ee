// What stands in a body that scatters behind a clear wall.
#include <gtest/gtest.h>

#include "testenv/support/furnace.h"
#include "testenv/support/medium_bodies.h"

namespace alabaster {
namespace {

using testing::add;
using testing::clear_body;
using testing::expect_furnace;
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
  DisneyParameters hull = clear_body(1.5f, 0.05f);
  for (const float ior : {1.0f, 1.33f})
    for (const auto& [content, what] : {std::pair(white_body(0), "matt"),
                                        {metal, "metal"},
                                        {clear_body(1.5f), "glass"},
                                        {white_body(0.05f), "wax"},
                                        {hull, "cloudy"}})
      expect_furnace(ball_with(clear_body(ior, 0.2f), content), kSights, {.runs = 32, .sees_background = true},
                     std::string(what) + " in index " + std::to_string(ior));
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

TEST(Contents, BlackOneIsTheSameAsOpaqueFacesOfTheBody) {
  const DisneyParameters milk = clear_body(1.33f, 0.3f);
  const SceneBuilder separate = ball_with(milk, matt(Rgb(0.0f)));
  SceneBuilder as_faces;
  Mesh ball = testing::sphere_mesh(1, 48, true), inner = ball;
  for (Vec3f& p : inner.points) p = p * 0.4f + Vec3f(0.2f, 0.1f, 0.1f);
  const size_t outer = ball.triangles.size();
  ball = testing::merged(ball, inner);
  ball.normals.clear(), ball.normal_triangles.clear();
  ball.triangle_material.assign(ball.triangles.size(), 1);
  std::fill_n(ball.triangle_material.begin(), outer, 0);
  add(&as_faces, as_faces.prototype(ball), milk);
  as_faces.description.instances.back().materials.push_back(as_faces.material(matt(Rgb(0.0f))));
  for (const Sight& sight : kSights) {
    const auto a = seen(separate, sight, 128), b = seen(as_faces, sight, 128);
    EXPECT_TRUE(testing::plausible(testing::z_test(a, b))) << sight.what;
    EXPECT_LT(a.mean(), 0.95);
  }
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
