#include "delegate/description/placement.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace alabaster::hd::description {
namespace {

using nlohmann::json;

Vec3d moved(const Vec3d& p, const Matrix4d& m) {
  return p * m;
}

void expect_near(const Vec3d& a, const Vec3d& b) {
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], 1e-12) << i;
}

TEST(PlacementTransform, ScalesThenRotatesAboutXYZThenTranslates) {
  const auto m = to_transform(json{{"scale", {2, 1, 1}}, {"rotate", {90, 0, 90}}, {"translate", {0, 0, 5}}});
  ASSERT_TRUE(m);
  expect_near(moved({1, 0, 0}, *m), {0, 2, 5});  // twice as long, still along x; then x -> y
  expect_near(moved({0, 1, 0}, *m), {0, 0, 6});  // y -> z
  expect_near(moved({0, 0, 1}, *m), {1, 0, 5});  // z -> -y -> x
}

TEST(PlacementTransform, RefusesWhatTheRendererWouldLeaveOut) {
  const auto scaled = [](double s) { return json{s, 0, 0, 0, 0, s, 0, 0, 0, 0, s, 0, 0, 0, 0, 1}; };
  EXPECT_TRUE(to_transform(scaled(1e-3)));
  EXPECT_FALSE(to_transform(scaled(0))) << "singular";
  EXPECT_FALSE(to_transform(scaled(1e300))) << "infinite in single precision";
  EXPECT_FALSE(to_transform(scaled(1e-60))) << "zero in single precision";
  EXPECT_FALSE(to_transform(json{1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1})) << "not affine";
  EXPECT_FALSE(to_transform(json{{"scale", {1, 0, 1}}}));
}

TEST(LookAt, PointsItsMinusZAtTheTarget) {
  const auto m = look_at({1, 2, 3}, {1, 2, -7}, {0, 1, 0}, false);
  ASSERT_TRUE(m);
  expect_near(moved({0, 0, -10}, *m), {1, 2, -7});
  expect_near(moved({0, 1, 0}, *m), {1, 3, 3});
  EXPECT_FALSE(look_at({1, 2, 3}, {1, 2, 3}, {0, 1, 0}, true)) << "no direction";
  EXPECT_FALSE(look_at({0, 5, 0}, {0, 0, 0}, {0, 1, 0}, false)) << "up along the view";
  EXPECT_TRUE(look_at({0, 5, 0}, {0, 0, 0}, {0, 1, 0}, true));
}

host::MeshDescription segment() {
  host::MeshDescription mesh;
  mesh.topology.faceVertexCounts = {3};
  mesh.topology.faceVertexIndices = {0, 1, 2};
  mesh.primvars["points"].value = Array<Vec3f>{{0, 0, 0}, {1, 0, 0}, {1, 1e-20f, 0}};
  return mesh;
}

/// The box about all that encloses a scene.
std::pair<Vec3d, Vec3d> bounds(host::RetainedSceneDelegate& scene) {
  Vec3d low(1e30), high(-1e30);
  for (const Vec3d& p : enclosing_points(scene))
    for (int i = 0; i < 3; ++i) {
      low[i] = std::min(low[i], p[i]);
      high[i] = std::max(high[i], p[i]);
    }
  return {low, high};
}

host::InstancerDescription instancer(std::map<Token, Value> primvars, const char* prototype, Array<int32_t> indices) {
  host::InstancerDescription d;
  d.primvars = std::move(primvars);
  d.indices = {{prototype, std::move(indices)}};
  return d;
}

struct InstancedSegment {
  host::RetainedSceneDelegate scene;
  explicit InstancedSegment(host::InstancerDescription d) {
    host::MeshDescription mesh = segment();
    mesh.instancer = "/instancer";
    scene.SetMesh("/segment", mesh);
    scene.SetInstancer("/instancer", std::move(d));
  }
};

TEST(EnclosingPoints, VisibleMeshesInWorldSpaceCount) {
  host::RetainedSceneDelegate scene;
  EXPECT_TRUE(enclosing_points(scene).empty());
  host::MeshDescription mesh = segment();
  mesh.transform[3][1] = 2;
  scene.SetMesh("/seen", mesh);
  mesh.transform[3][1] = 50;
  mesh.visible = false;
  scene.SetMesh("/hidden", mesh);
  const auto [low, high] = bounds(scene);
  expect_near(low, {0, 2, 0});
  expect_near(high, {1, 2, 0});
}

TEST(EnclosingPoints, PointsOfFacesThatAreDrawnCount) {
  for (const bool instanced : {false, true}) {
    host::RetainedSceneDelegate scene;
    host::MeshDescription mesh;
    mesh.topology.faceVertexCounts = {3, 3, 3, 3};
    mesh.topology.faceVertexIndices = {1, 2, 3, 3, 2, 4, 1, 2, 5, 1, 2, 77};
    mesh.topology.holeIndices = {1};
    mesh.topology.invisibleFaces = {2};
    mesh.primvars["points"].value =
        Array<Vec3f>{{-900, 0, 0}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 700, 0}, {0, 0, 600}, {0, 0, -500}};
    if (instanced) {
      mesh.instancer = "/instancer";
      scene.SetInstancer("/instancer", instancer({{"hydra:instanceTranslations", Array<Vec3f>{{0, 0, 0}, {0, 0, 0}}}},
                                                 "/mesh", {0, 1}));
    }
    scene.SetMesh("/mesh", mesh);
    const auto [low, high] = bounds(scene);
    expect_near(low, {0, 0, 0});
    expect_near(high, {1, 1, 0});
  }
}

TEST(EnclosingPoints, FacesWithoutAreaDoNotCount) {
  host::RetainedSceneDelegate scene;
  host::MeshDescription mesh = segment();
  mesh.topology.faceVertexCounts = {3, 3, 4};
  mesh.topology.faceVertexIndices = {0, 1, 2, 3, 3, 3, 0, 3, 3, 0};
  mesh.primvars["points"].value = Array<Vec3f>{{0, 0, 0}, {1, 0, 0}, {1, 1e-20f, 0}, {300, 200, 100}};
  scene.SetMesh("/mesh", mesh);
  expect_near(bounds(scene).second, {1, 0, 0});
}

TEST(EnclosingPoints, InstancesThatCannotBeDrawnDoNotCount) {
  host::RetainedSceneDelegate scene;
  host::MeshDescription mesh = segment();
  scene.SetMesh("/seen", mesh);
  for (int i = 0; i < 3; ++i) mesh.transform[i][i] = 0, mesh.transform[3][i] = 500;
  scene.SetMesh("/point", mesh);
  expect_near(bounds(scene).second, {1, 0, 0});
}

// A quarter turn about z, given by a quaternion of length 3: drawing normalises it (Instancer::Sync), and so must this.
TEST(EnclosingPoints, InstanceRotationsCountByTheirDirectionAlone) {
  const float c = 3 * std::sqrt(0.5f);
  for (const Value& rotations : {Value(Array<Quatf>{{c, 0, 0, c}}), Value(Array<Vec4f>{{c, 0, 0, c}})}) {
    InstancedSegment instanced(instancer({{"hydra:instanceRotations", rotations}}, "/segment", {0}));
    const auto [low, high] = bounds(instanced.scene);
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(low[i], 0, 1e-6);
      EXPECT_NEAR(high[i], i == 1 ? 1 : 0, 1e-6);
    }
  }
}

TEST(EnclosingPoints, HiddenInstancesDoNotCount) {
  const Array<Vec3f> places{{0, 0, 0}, {0, 4, 0}};
  InstancedSegment instanced(instancer({{"hydra:instanceTranslations", places}}, "/segment", {1, 7, -1}));
  const auto [low, high] = bounds(instanced.scene);
  expect_near(low, {0, 4, 0});
  expect_near(high, {1, 4, 0});

  InstancedSegment orphan(instancer({}, "/another", {0}));
  EXPECT_TRUE(enclosing_points(orphan.scene).empty()) << "no index places it";
  orphan.scene.Remove("/instancer");
  EXPECT_TRUE(enclosing_points(orphan.scene).empty()) << "no instancer places it";
}

TEST(EnclosingPoints, FollowNestedInstancersAndEndInACycle) {
  InstancedSegment nested(instancer({{"hydra:instanceTranslations", Array<Vec3f>{{1, 0, 0}}}}, "/segment", {0}));
  host::InstancerDescription inner = nested.scene.GetInstancers().at("/instancer");
  inner.parent = "/outer";
  nested.scene.SetInstancer("/instancer", inner);
  host::InstancerDescription outer =
      instancer({{"hydra:instanceTranslations", Array<Vec3f>{{0, 10, 0}, {0, 20, 0}}}}, "/instancer", {0, 1});
  nested.scene.SetInstancer("/outer", outer);
  const auto [low, high] = bounds(nested.scene);
  expect_near(low, {1, 10, 0});
  expect_near(high, {2, 20, 0});
  outer.parent = "/instancer";
  nested.scene.SetInstancer("/outer", outer);
  EXPECT_TRUE(enclosing_points(nested.scene).empty()) << "not drawn either";
}

// Seen from the camera, every point lies within the frame, and the margin is not larger than it says.
TEST(FramePoints, ShowsEveryPointAsLargeAsItCan) {
  const std::vector<Vec3d> points{{-1, 0, 0}, {3, 0, 1}, {0, 2, 0}, {0, -1, -2}};
  const Frustum frustum{0.36, 0.24};
  const Framed framed = frame_points(points, frustum);
  const Matrix4d to_camera = framed.camera.inverse();
  double largest = 0;
  for (const Vec3d& p : points) {
    const Vec3d c = p * to_camera;
    ASSERT_LT(c.z, 0) << "before the camera";
    largest = std::max({largest, std::abs(c.x / c.z) / frustum.tan_x, std::abs(c.y / c.z) / frustum.tan_y});
  }
  EXPECT_NEAR(largest, 0.86, 1e-9);
  EXPECT_GT(framed.distance, 0);
}

TEST(FramePoints, OnePointAndNoneAreShownToo) {
  const Framed one = frame_points({{5, 6, 7}}, {});
  const Vec3d seen = Vec3d(5, 6, 7) * one.camera.inverse();
  expect_near(seen, {0, 0, -one.distance});
  EXPECT_GT(one.distance, 0);
  EXPECT_GT(frame_points({}, {}).distance, 0);
}

}  // namespace
}  // namespace alabaster::hd::description
