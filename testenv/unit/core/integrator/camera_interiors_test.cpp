#include "core/integrator/camera_interiors.h"

#include <gtest/gtest.h>

#include "core/diagnostics/cancel.h"
#include "core/integrator/interface.h"
#include "testenv/support/path_tracer.h"

namespace alabaster {
namespace {

using testing::SceneBuilder;

DisneyParameters glass(float ior) {
  DisneyParameters p;
  p.spec_trans = 1;
  p.ior = ior;
  return p;
}

Matrix4d at(double x, double y, double z) {
  return Matrix4d().setTranslation(Vec3d(x, y, z));
}

/// A camera at the origin of the world, which looks down -z, and what its rays find.
struct View {
  explicit View(SceneBuilder* builder) : scene(builder->snapshot()) {}

  std::unique_ptr<const CameraInteriors> find() {
    const MovingCamera moving(camera, 8, 8, scene->origin);
    return CameraInteriors::find(context(moving.first()), moving.ray_origins({0, 0}, {8, 8}));
  }
  PathContext context(const Camera& at) { return {*scene, at, settings, counters}; }
  /// The rays that `found` costs for a ray of the camera, and the index of refraction there.
  std::pair<uint64_t, float> cost_and_index(const CameraInteriors& found, const Vec2f& film) {
    const MovingCamera moving(camera, 8, 8, scene->origin);
    counters = {};
    const float index = found.of(context(moving.first()), moving.first().generate_ray(film, {0.5f, 0.5f})).index();
    return {counters.rays(), index};
  }

  std::shared_ptr<const SceneSnapshot> scene;
  CameraParameters camera;
  IntegratorSettings settings = integrator_settings({});
  RenderCounters counters;
};

TEST(CameraInteriors, BodiesWhoseBoxesAreElsewhereCostNothing) {
  SceneBuilder b;
  const auto ball = b.prototype(testing::sphere_mesh(1, 16, true));
  b.add(ball, b.material(glass(1.5f)), at(-9, -9, -9)).add(ball, b.material(glass(1.5f)), at(9, 9, 9));
  View view(&b);
  ASSERT_TRUE(view.scene->clear_bodies.contains(Vec3f(-view.scene->origin))) << "the box around both";
  EXPECT_FALSE(view.find());
  view.camera.focal_length = 20;
  view.camera.f_stop = 20;
  view.camera.focus_distance = 5;
  EXPECT_FALSE(view.find()) << "a lens";
  view.camera.poses = {at(0, 0, 0), at(0.5, 0, 0)};
  EXPECT_FALSE(view.find()) << "a camera that moves";
}

TEST(CameraInteriors, TheSearchEndsWithTheTimeOfTheRender) {
  SceneBuilder b;
  b.add(b.prototype(testing::sphere_mesh(1, 256, true)), b.material(glass(1.5f)), at(0, 0, 0));
  View view(&b);
  view.camera.focal_length = 20;
  view.camera.f_stop = 2000;
  view.camera.focus_distance = 5;
  const MovingCamera moving(view.camera, 8, 8, view.scene->origin);
  const Bounds origins = moving.ray_origins({0, 0}, {8, 8});
  std::atomic<bool> over{false};
  view.settings.walk.cancel = CancelToken(&over);
  const PathContext context = view.context(moving.first());
  ASSERT_NO_THROW(CameraInteriors::find(context, origins));
  over = true;
  EXPECT_THROW(CameraInteriors::find(context, origins), BuildCancelled);
}

TEST(CameraInteriors, AStillCameraInABodyIsFoundOnce) {
  SceneBuilder b;
  const auto ball = b.prototype(testing::sphere_mesh(1, 32, true));
  const auto large = b.prototype(testing::sphere_mesh(3, 32, true));
  b.add(large, b.material(glass(1.3f))).add(ball, b.material(glass(1.5f)));
  View view(&b);
  for (const float clip_near : {0.0f, 0.1f}) {
    view.camera.clip_near = clip_near;
    const auto found = view.find();
    ASSERT_TRUE(found);
    for (const Vec2f& film : {Vec2f(0, 0), Vec2f(4, 4), Vec2f(7, 2)})
      EXPECT_EQ(view.cost_and_index(*found, film), std::make_pair(uint64_t(0), 1.5f)) << clip_near;
  }
}

// A box that the camera stands in, of a body that it does not stand in.
TEST(CameraInteriors, AStillCameraBesideABodyInItsBoxCostsNothing) {
  SceneBuilder b;
  Mesh two = testing::sphere_mesh(1, 16, true);
  const auto points = two.points.size();
  const auto corners = two.triangles;
  for (size_t i = 0; i < points; ++i) {
    two.points.push_back(two.points[i] + Vec3f(5, 5, 5));
    two.normals.push_back(two.normals[i]);
    two.points[i] -= Vec3f(5, 5, 5);
  }
  for (Corners c : corners) {
    for (uint32_t& corner : c) corner += static_cast<uint32_t>(points);
    two.triangles.push_back(c);
    two.triangle_face.push_back(0);
  }
  two.triangle_face.clear();
  two.bounds = {Vec3f(-6, -6, -6), Vec3f(6, 6, 6)};
  b.add(b.prototype(std::move(two)), b.material(glass(1.5f)));
  View view(&b);
  EXPECT_FALSE(view.find());
}

TEST(CameraInteriors, EachRayFindsItsOwnWhereTheyMayDiffer) {
  // The near plane cuts the body.
  SceneBuilder b;
  b.add(b.prototype(testing::sphere_mesh(1, 32, true)), b.material(glass(1.5f)), at(0.6, 0, -0.5));
  View cut(&b);
  cut.camera.focal_length = 18;
  cut.camera.clip_near = 0.5f;
  const auto found = cut.find();
  ASSERT_TRUE(found);
  const auto [outside_cost, outside] = cut.cost_and_index(*found, {0, 4});
  const auto [inside_cost, inside] = cut.cost_and_index(*found, {7, 4});
  EXPECT_EQ(outside, 1);
  EXPECT_EQ(inside, 1.5f);
  EXPECT_GT(inside_cost, 0u) << "its rays are counted";

  // A body that is open has an inside for some directions alone.
  SceneBuilder open;
  Mesh bowl = testing::sphere_mesh(1, 32, true);
  bowl.triangles.resize(bowl.triangles.size() / 2);
  bowl.closed = bowl.sealed = bowl.outward = false;
  open.add(open.prototype(std::move(bowl)), open.material(glass(1.5f)));
  View view(&open);
  const auto of_open = view.find();
  ASSERT_TRUE(of_open);
  EXPECT_GT(view.cost_and_index(*of_open, {4, 4}).first, 0u);
}

}  // namespace
}  // namespace alabaster
