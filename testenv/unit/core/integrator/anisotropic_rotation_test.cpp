// Turning the highlight: the local frame stands along the texture coordinates' directions, however they lie.
#include <gtest/gtest.h>

#include <cmath>

#include "core/integrator/vertex.h"
#include "testenv/support/path_tracer.h"

namespace alabaster {
namespace {

// A square in the xz plane. u grows along the first direction, v along the second.
struct Square {
  Vec3f u{1, 0, 0}, v{0, 0, -1};
  Matrix4d transform = {};
  Vec3d eye{0.1, 3, 0.2};
  bool has_uv = true;

  Vec3f tangent(float rotation) const {
    testing::SceneBuilder b;
    Mesh mesh = testing::plane_mesh(2);
    if (has_uv) mesh.uv_sets.push_back({{}, "st"});
    for (const Vec3f& p : has_uv ? mesh.points : std::vector<Vec3f>())
      mesh.uv_sets[0].values.emplace_back(dot(p, u), dot(p, v));
    DisneyParameters metal;
    metal.anisotropic = 0.8f;
    metal.anisotropic_rotation = rotation;
    b.add(b.prototype(std::move(mesh)), b.material(metal), transform);
    const auto scene = b.snapshot();
    testing::PathTracer tracer(scene, eye);
    const Ray ray{Vec3f(eye - scene->origin), normalize(Vec3f(-eye))};
    TriangleHit hit;
    EXPECT_TRUE(scene->top->intersect(ray, &hit));
    Vertex v;
    evaluate_surface(tracer.context(), ray, hit, 0, &v);
    return v.frame.s;
  }
};

void expect_near(const Vec3f& a, const Vec3f& b) {
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], 2e-6f) << i;
}

TEST(AnisotropicRotation, TurnsFromGrowingUTowardsGrowingV) {
  const Square plain;
  expect_near(plain.tangent(0), {1, 0, 0});
  expect_near(plain.tangent(0.25f), {0, 0, -1});
  expect_near(plain.tangent(0.125f), {std::sqrt(0.5f), 0, -std::sqrt(0.5f)});
  expect_near(plain.tangent(0.75f), {0, 0, 1});
  expect_near(plain.tangent(-3.25f), {0, 0, 1});
  expect_near(plain.tangent(1e30f), {1, 0, 0});
}

TEST(AnisotropicRotation, FollowsMirroredCoordinatesTransformsAndSides) {
  expect_near(Square{.v = {0, 0, 1}}.tangent(0.25f), {0, 0, 1});
  expect_near(Square{.eye = {0.1, -3, 0.2}}.tangent(0.25f), {0, 0, -1});
  expect_near(Square{.transform = Matrix4d().setScale(Vec3d(-1, 1, 1))}.tangent(0.25f), {0, 0, -1});
  expect_near(Square{.transform = Matrix4d().setScale(Vec3d(-1, 1, 1))}.tangent(0), {-1, 0, 0});
  expect_near(
      Square{.v = {0, 0, 1}, .transform = Matrix4d().setScale(Vec3d(-1, 1, 1)), .eye = {0.1, -3, 0.2}}.tangent(0.25f),
      {0, 0, 1});
}

// Object, light and camera turned together show the same picture.
TEST(AnisotropicRotation, WithoutCoordinatesItTurnsWithTheObject) {
  for (const Vec3d& axis : {Vec3d(0, 1, 0), Vec3d(1, 0, 0), Vec3d(1, 2, 3)})
    for (const double angle : {0.5, 1.6, 2.5, 3.1})
      for (const float rotation : {0.0f, 0.1f}) {
        const Matrix4d turn = Matrix4d().setAxisAngle(normalize(axis), angle);
        Square square{.has_uv = false};
        const Vec3f at_rest = square.tangent(rotation);
        square.transform = turn;
        turn.multDirMatrix(square.eye, square.eye);
        Vec3f expected;
        turn.multDirMatrix(at_rest, expected);
        expect_near(square.tangent(rotation), expected);
      }
}

// About the y axis of the object.
TEST(AnisotropicRotation, TheStandInTangentIsThatOfASphereOfLatitudes) {
  SurfacePoint at;
  at.ns = normalize(Vec3f(1, 2, 0));
  expect_near(stand_in_tangent(at, Affine()), {0, 0, -1});
  at.ns = normalize(Vec3f(0, -2, 1));
  expect_near(stand_in_tangent(at, Affine()), {1, 0, 0});
  at.ns = Vec3f(0, 1, 0);
  expect_near(stand_in_tangent(at, Affine()), {1, 0, 0});
}

}  // namespace
}  // namespace alabaster
