#include "core/geometry/surface_hit.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "testenv/support/cages.h"

namespace alabaster {
namespace {

using Random = std::mt19937;

float uniform(Random& random) {
  return std::uniform_real_distribution<float>(0, 1)(random);
}

Vec3f random_direction(Random& random) {
  const float z = 1 - 2 * uniform(random), phi = kTwoPi * uniform(random);
  const float r = std::sqrt(std::max(0.0f, 1 - z * z));
  return {r * std::cos(phi), r * std::sin(phi), z};
}

struct Transform {
  Affine forward, inverse;
};

Transform make_transform(const Matrix4d& m) {
  return {to_affine(m), to_affine(m.inverse())};
}

Matrix4d rotation(const Vec3d& angles) {
  Matrix4d m;
  m.setEulerAngles(angles);
  return m;
}
Matrix4d scaling(const Vec3d& s) {
  Matrix4d m;
  m.setScale(s);
  return m;
}
Matrix4d translation(const Vec3d& t) {
  Matrix4d m;
  m.setTranslation(t);
  return m;
}

// Row vectors: the left factor acts first.
std::vector<Matrix4d> placements() {
  const Matrix4d r = rotation({0.3, 1.1, -0.7}), r2 = rotation({-1.9, 0.4, 0.2});
  return {Matrix4d(),
          r,
          translation({1000, -333, 71}),
          scaling({1, 100, 0.1}) * r * translation({5, 6, 7}),
          r * scaling({1, 4, 0.2}) * r2 * translation({300, -20, 1000}),
          scaling({-1, 1, 1}) * r * translation({0, 64, 0}),
          scaling({1e-3, 1e-3, 1e-3}) * r * translation({10, 10, 10})};
}

// A geodesic sphere: an octahedron whose triangles are split in four `level` times, on the unit sphere. Convex.
Mesh sphere(int level) {
  Mesh mesh = build_mesh(test::octahedron_cage(), {}, {});
  for (int i = 0; i < level; ++i) {
    Mesh finer;
    for (const auto& t : mesh.triangles) {
      const auto first = static_cast<uint32_t>(finer.points.size());
      for (size_t k = 0; k < 3; ++k) finer.points.push_back(mesh.points[t[k]]);
      for (size_t k = 0; k < 3; ++k) finer.points.push_back(normalize(mesh.points[t[k]] + mesh.points[t[(k + 1) % 3]]));
      for (auto c : {std::array<uint32_t, 3>{0, 3, 5}, {3, 1, 4}, {5, 4, 2}, {3, 4, 5}})
        finer.triangles.push_back({first + c[0], first + c[1], first + c[2]});
    }
    mesh = finer;
  }
  return mesh;
}

Mesh moved(Mesh mesh, const Vec3f& by, float scale) {
  for (Vec3f& p : mesh.points) p = (p + by) * scale;
  return mesh;
}

std::vector<Mesh> convex_meshes() {
  return {build_mesh(test::cube_cage(), {}, {}), build_mesh(test::octahedron_cage(), {}, {}), sphere(2)};
}

TriangleHit random_hit(const Mesh& mesh, Random& random) {
  TriangleHit hit;
  hit.triangle = static_cast<uint32_t>(random() % mesh.triangles.size());
  hit.u = uniform(random);
  hit.v = uniform(random);
  if (hit.u + hit.v > 1) hit.u = 1 - hit.u, hit.v = 1 - hit.v;
  return hit;
}

// Inward, a point within its own uncertainty of an edge may step through the neighbouring face: ask in the middle.
TriangleHit middle_hit(const Mesh& mesh, Random& random) {
  TriangleHit hit = random_hit(mesh, random);
  hit.u = 0.2f + 0.4f * hit.u;
  hit.v = 0.2f + 0.4f * hit.v;
  return hit;
}

class RayOrigins : public ::testing::TestWithParam<int> {
 protected:
  std::shared_ptr<TraceDevice> device_ = make_trace_device({});
  float scale_ = std::ldexp(1.0f, GetParam());
};

TEST_P(RayOrigins, LeavingAConvexMeshMeetsNothingAndEnteringMeetsTheFarSide) {
  Random random(7);
  size_t rehits_without_offset = 0, rays = 0;
  for (const Mesh& shape : convex_meshes())
    for (const Vec3f& by : {Vec3f(0, 0, 0), Vec3f(64, -128, 32)}) {
      const Mesh mesh = moved(shape, by, scale_);
      const auto object = build_object_scene(device_, mesh, {});
      for (Matrix4d matrix : placements()) {
        for (int i = 0; i < 3; ++i) matrix[3][i] *= scale_;
        const Transform transform = make_transform(matrix);
        const auto scene = build_instanced_scene(device_, {{object, transform.forward}});
        for (int i = 0; i < 1000; ++i, ++rays) {
          TriangleHit hit = i % 2 ? random_hit(mesh, random) : middle_hit(mesh, random);
          // Every other one close to an edge, where the neighbour must not be met either.
          if (i % 2) hit.u *= std::ldexp(1.0f, -1 - i % 24);
          const SurfaceHit s = surface_hit(mesh, hit, transform.forward, transform.inverse);
          Vec3f out = random_direction(random);
          if (dot(out, s.ng) < 0) out = -out;
          TriangleHit again;
          EXPECT_FALSE(scene->occluded({offset_point(s.p, s.ng, s.offset), out})) << "instance, outward";
          rehits_without_offset += scene->occluded({s.p, out});
          if (i % 2) continue;
          ASSERT_TRUE(scene->intersect({offset_point(s.p, s.ng, -s.offset), -out}, &again));
          EXPECT_NE(again.triangle, hit.triangle);
          EXPECT_GT(dot(surface_hit(mesh, again, transform.forward, transform.inverse).ng, -out), 0);
        }
      }
    }
  EXPECT_GT(rehits_without_offset, rays / 10);  // the trap is there
}

TEST_P(RayOrigins, ObjectSpaceIsSafeByItself) {
  Random random(11);
  for (const Mesh& shape : convex_meshes())
    for (const Vec3f& by : {Vec3f(0, 0, 0), Vec3f(64, -128, 32)}) {
      const Mesh mesh = moved(shape, by, scale_);
      const auto object = build_object_scene(device_, mesh, {});
      for (int i = 0; i < 2000; ++i) {
        TriangleHit hit = i % 2 ? random_hit(mesh, random) : middle_hit(mesh, random);
        if (i % 2) hit.u *= std::ldexp(1.0f, -1 - i % 24);
        const SurfaceHit s = surface_hit(mesh, hit, {}, {});
        Vec3f out = random_direction(random);
        if (dot(out, s.ng_object) < 0) out = -out;
        TriangleHit again;
        EXPECT_FALSE(object->intersect({offset_point(s.p_object, s.ng_object, s.offset_object), out}, &again));
        if (i % 2) continue;
        ASSERT_TRUE(object->intersect({offset_point(s.p_object, s.ng_object, -s.offset_object), -out}, &again));
        EXPECT_NE(again.triangle, hit.triangle);
      }
    }
}

INSTANTIATE_TEST_SUITE_P(Scales, RayOrigins, ::testing::Values(-20, -7, 0, 9, 20));

// A small bump on the offset: no more than the bound needs. Sixteen units in the last place of the largest coordinate
// in one space are known to suffice; the top level adds the way through two more spaces.
TEST(SurfaceHit, OffsetsAreAFewUnitsInTheLastPlace) {
  Random random(3);
  for (const Mesh& mesh : convex_meshes())
    for (int i = 0; i < 100; ++i) {
      const SurfaceHit s = surface_hit(mesh, random_hit(mesh, random), {}, {});
      EXPECT_GT(s.offset_object, 1 * 0x1p-23f);
      EXPECT_LT(s.offset_object, 10 * 0x1p-23f);
      EXPECT_GE(s.offset, s.offset_object * 0.9f);
      EXPECT_LT(s.offset, 24 * 0x1p-23f);
    }
}

// One right triangle in z = 0, seen from +z.
Mesh triangle() {
  Mesh mesh;
  mesh.points = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}};
  mesh.triangles = {{0, 1, 2}};
  return mesh;
}

TriangleHit hit_at(float u, float v) {
  TriangleHit hit;
  hit.u = u;
  hit.v = v;
  return hit;
}

TEST(SurfaceHit, AttributesComeFromTheirOwnCorners) {
  Mesh mesh = triangle();
  mesh.uv_sets.resize(1);
  mesh.uv_sets[0].values = {{9, 9}, {0, 0}, {0, 1}, {-1, 0}};  // u grows along -y, v along x
  mesh.uv_sets[0].triangles = {{1, 2, 3}};
  mesh.normals = {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}};
  mesh.normal_triangles = {{0, 1, 2}};
  mesh.triangle_face = {17};
  mesh.triangle_material = {3};
  const SurfaceHit s = surface_hit(mesh, hit_at(0.25f, 0.5f), {}, {});
  EXPECT_EQ(s.p, Vec3f(0.5f, 1, 0));
  EXPECT_EQ(s.p_object, s.p);
  EXPECT_EQ(s.ng, Vec3f(0, 0, 1));
  EXPECT_EQ(s.uv, Vec2f(-0.5f, 0.25f));
  EXPECT_EQ(mesh.element(0), 17);
  EXPECT_NEAR(length(s.ns - normalize(Vec3f(0.25f, 0.5f, 0.25f))), 0, 1e-6f);
  EXPECT_NEAR(length(s.dpdu - Vec3f(0, -1, 0)), 0, 1e-6f);
  // A transform that turns x into y and stretches: dpdu follows as a vector.
  const Transform t = make_transform(rotation({0, 0, kPi / 2.0}) * scaling({3, 1, 1}));
  const SurfaceHit turned = surface_hit(mesh, hit_at(0.25f, 0.5f), t.forward, t.inverse);
  EXPECT_NEAR(length(turned.dpdu - Vec3f(1, 0, 0)), 0, 1e-6f);
}

TEST(SurfaceHit, ShadingNormalsStayOnTheOutwardSide) {
  Mesh mesh = triangle();
  // Authored for the other side: turned over as a whole, so the tilt is kept.
  mesh.normals.assign(3, normalize(Vec3f(0.5f, 0, -1)));
  EXPECT_NEAR(length(surface_hit(mesh, hit_at(0.2f, 0.3f), {}, {}).ns - normalize(Vec3f(-0.5f, 0, 1))), 0, 1e-6f);
  // One corner that leans over the horizon: bent back without a jump.
  mesh.normals = {{0, 0, 1}, {1, 0, -0.25f}, {0, 0, 1}};
  Vec3f last = surface_hit(mesh, hit_at(0, 0), {}, {}).ns;
  for (int i = 1; i <= 256; ++i) {
    const Vec3f ns = surface_hit(mesh, hit_at(static_cast<float>(i) / 256, 0), {}, {}).ns;
    EXPECT_GE(ns.z, 0);
    EXPECT_LT(length(ns - last), 0.02f);
    last = ns;
  }
  // No direction at all: the geometric normal.
  mesh.normals.assign(3, Vec3f(0, 0, 0));
  EXPECT_EQ(surface_hit(mesh, hit_at(0.2f, 0.3f), {}, {}).ns, Vec3f(0, 0, 1));
}

TEST(SurfaceHit, DegenerateInputStaysFinite) {
  Mesh mesh = triangle();
  mesh.uv_sets.resize(1);
  mesh.uv_sets[0].values.assign(3, Vec2f(0.5f, 0.5f));  // no direction of u
  SurfaceHit s = surface_hit(mesh, hit_at(0.2f, 0.3f), {}, {});
  EXPECT_NEAR(length(s.dpdu), 1, 1e-6f);
  EXPECT_NEAR(dot(s.dpdu, s.ns), 0, 1e-6f);
  mesh.points.assign(3, Vec3f(1, 2, 3));  // no area
  s = surface_hit(mesh, hit_at(0.2f, 0.3f), {}, {});
  EXPECT_NEAR(length(s.ng), 1, 1e-6f);
  EXPECT_TRUE(is_finite(s.p));
  EXPECT_TRUE(std::isfinite(s.offset));
}

}  // namespace
}  // namespace alabaster
