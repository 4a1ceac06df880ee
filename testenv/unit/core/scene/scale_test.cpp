// A scene times 2^k renders to the same bits in the range that core/README.md states, and is a fault of the scene where
// pictures would be wrong.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "core/scene/snapshot_compiler.h"
#include "testenv/support/scene_builder.h"

namespace alabaster {
namespace {

using testing::SceneBuilder;

// Bodies, glass and metal on a floor, in the light of a lamp, a panel and a dome; a few units wide.
RenderRequest still_life(double s, SceneBuilder* b) {
  const auto f = static_cast<float>(s);
  DisneyParameters wax, glass, metal;
  wax.base_color = {0.9f, 0.6f, 0.45f};
  wax.scatter_distance = Rgb(0.3f, 0.1f, 0.05f) * f;
  DisneyParameters milk = wax;
  milk.scatter_anisotropy = 0.7f;
  glass.spec_trans = 1;
  glass.roughness = 0.1f;
  metal.metallic = 1;
  metal.roughness = 0.2f;
  const auto ball = b->prototype(testing::sphere_mesh(0.5f * f, 16, true));
  b->add(ball, b->material(wax), Matrix4d().setTranslation(Vec3d(-1, 0.5, 0) * s));
  b->add(ball, b->material(milk), Matrix4d().setTranslation(Vec3d(-0.6, 0.5, -1.2) * s));
  b->add(ball, b->material(glass), Matrix4d().setTranslation(Vec3d(0, 0.5, 0.6) * s));
  b->add(ball, b->material(metal), Matrix4d().setTranslation(Vec3d(1, 0.5, 0) * s));
  b->add(b->prototype(testing::plane_mesh(6 * f)), b->material({}));
  LightParameters lamp;
  lamp.type = LightType::sphere;
  lamp.radius = 0.1f * f;
  lamp.intensity = 100;
  lamp.light_to_world.setTranslation(Vec3d(2, 3, 1) * s);
  LightParameters panel;
  panel.type = LightType::rect;
  panel.width = panel.height = f;
  panel.intensity = 4;
  panel.light_to_world.setTranslation(Vec3d(-1, 1.5, 3) * s);
  b->add(lamp).add(panel).add(testing::constant_dome(0.2f, true));
  RenderRequest request;
  request.scene = b->snapshot();
  request.camera = testing::look_at(Vec3d(0, 1.5, 5) * s, Vec3d(0, 0.4, 0) * s, 40);
  request.width = request.height = 32;
  request.data_window = {0, 0, 32, 32};
  request.settings.samples = 8;
  return request;
}

std::vector<float> picture(int k, SceneBuilder* b, SubsurfaceMode mode = SubsurfaceMode::walk) {
  RenderRequest request = still_life(std::ldexp(1.0, k), b);
  request.settings.subsurface = mode;
  return testing::render(request)->resolve_float(Aov::color);
}

double mean_of(const std::vector<float>& pixels) {
  double sum = 0;
  for (const float v : pixels) sum += v;
  return sum / static_cast<double>(pixels.size());
}

// The still life has a radius of 4.3 units, a little more than 2^2.
TEST(Scale, PowersOfTwoChangeNoBitAtTheEndsOfTheRange) {
  for (const SubsurfaceMode mode : {SubsurfaceMode::walk, SubsurfaceMode::diffusion}) {
    SceneBuilder one;
    const auto expected = picture(0, &one, mode);
    EXPECT_LT(one.snapshot()->radius, 8);
    EXPECT_GT(one.snapshot()->radius, 4);
    for (const int k : {-18, 3, 27}) {
      SceneBuilder b;
      EXPECT_EQ(picture(k, &b, mode), expected) << "2^" << k;
    }
  }
}

TEST(Scale, BeyondThemPicturesStayRight) {
  SceneBuilder one;
  const double expected = mean_of(picture(0, &one));
  for (const int k : {-36, 37}) {
    SceneBuilder b;
    EXPECT_NEAR(mean_of(picture(k, &b)) / expected, 1, 0.02) << "2^" << k;
    EXPECT_TRUE(b.snapshot()->faults.empty());
  }
}

TEST(Scale, FarBeyondThemASceneIsAFault) {
  for (const int k : {-46, 44}) {
    SceneBuilder b;
    const auto f = static_cast<float>(std::ldexp(1.0, k));
    b.add(b.prototype(testing::plane_mesh(6 * f)), b.material({}));
    std::string error;
    const auto snapshot =
        compile_snapshot(b.description, 1, make_trace_device({}), [&](const Diagnostic& d) { error += d.code; });
    EXPECT_EQ(error, "scene.scale") << "2^" << k;
    ASSERT_EQ(snapshot->faults.size(), 1u) << "2^" << k;
    EXPECT_NE(snapshot->faults[0].find("metersPerUnit"), std::string::npos) << snapshot->faults[0];
  }
}

// A black frame would look converged.
TEST(Scale, AFrameWithoutATraceableRayFails) {
  SceneBuilder b;
  RenderRequest request = still_life(1, &b);
  request.camera.camera_to_world.setTranslation(Vec3d(0, 0, 1e18));
  RenderSession session;
  session.start(request);
  ASSERT_TRUE(session.wait(60));
  const RenderProgress progress = session.progress();
  EXPECT_EQ(progress.state, SessionState::failed);
  EXPECT_NE(progress.error.find("scale the scene"), std::string::npos) << progress.error;
}

}  // namespace
}  // namespace alabaster
