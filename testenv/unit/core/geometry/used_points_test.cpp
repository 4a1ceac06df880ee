#include "core/geometry/used_points.h"

#include <gtest/gtest.h>

#include "core/geometry/mesh.h"
#include "testenv/support/cages.h"

namespace alabaster {
namespace {

// Loose points before, between and behind the others, with values of each kind.
Cage with_loose_points(const Cage& cage) {
  Cage loose = cage;
  loose.points.clear();
  for (const Vec3f& p : cage.points) {
    loose.points.emplace_back(100.0f, 0.0f, 0.0f);
    loose.points.push_back(p);
  }
  loose.points.emplace_back(0.0f, -900.0f, 0.0f);
  for (int& i : loose.face_vertex_indices) i = 2 * i + 1;
  for (int& i : loose.crease_indices) i = 2 * i + 1;
  for (int& i : loose.corner_indices) i = 2 * i + 1;
  return loose;
}

template <class T>
void add_values(const Cage& cage, T value, bool indexed, Primvar<T>* primvar) {
  for (size_t i = 0; i < cage.points.size(); ++i)
    primvar->values.push_back(value * (1.0f + max_abs_component(cage.points[i]) + cage.points[i].x));
  for (size_t i = 0; i < cage.points.size() && indexed; ++i) primvar->indices.push_back(static_cast<int>(i));
}

void add_primvars(bool indexed, Cage* cage) {
  add_values(*cage, Vec3f(0.1f, 0.2f, 1), indexed, &cage->normals);
  cage->uvs.emplace_back();
  cage->uvs[0].name = "st";
  add_values(*cage, Vec2f(0.5f, 0.25f), indexed, &cage->uvs[0]);
  cage->primvars = {{Primvar<Vec4f>(), "tint"}};
  add_values(*cage, Vec4f(0.01f), indexed, &std::get<Primvar<Vec4f>>(cage->primvars[0].values));
}

TEST(UsedPoints, TheMeshIsThatWithoutLoosePoints) {
  for (const auto scheme : {SubdivisionScheme::none, SubdivisionScheme::catmull_clark})
    for (const bool indexed : {false, true}) {
      Cage plain = test::cube_cage();
      plain.scheme = scheme;
      plain.crease_indices = {0, 1}, plain.crease_lengths = {2}, plain.crease_sharpnesses = {2};
      plain.corner_indices = {7}, plain.corner_sharpnesses = {3};
      plain.normals = {}, plain.uvs.clear();
      Cage loose = with_loose_points(plain);
      add_primvars(indexed, &plain), add_primvars(indexed, &loose);
      ASSERT_TRUE(sanitize_cage(plain, "", {}) && sanitize_cage(loose, "", {}));
      drop_unused_points(&loose);
      EXPECT_EQ(loose.points, plain.points);
      EXPECT_EQ(loose.face_vertex_indices, plain.face_vertex_indices);
      EXPECT_EQ(loose.crease_indices, plain.crease_indices);
      RefinementOptions options;
      options.level = 2;
      const Mesh a = build_mesh(plain, options, {}), b = build_mesh(loose, options, {});
      EXPECT_EQ(a.points, b.points);
      EXPECT_EQ(a.triangles, b.triangles);
      if (indexed) continue;  // values that no index names stay
      EXPECT_EQ(a.normals, b.normals);
      EXPECT_EQ(a.uv_sets[0].values, b.uv_sets[0].values);
      const auto tint = [](const Mesh& mesh) { return std::get<MeshAttribute<Vec4f>>(mesh.primvars[0].values).values; };
      EXPECT_EQ(tint(a), tint(b));
      EXPECT_EQ(a.memory_bytes(), b.memory_bytes());
    }
}

TEST(UsedPoints, CagesWithoutLoosePointsStayAsTheyAre) {
  Cage cube = test::cube_cage();
  const Cage before = cube;
  drop_unused_points(&cube);
  EXPECT_EQ(cube.points, before.points);
  EXPECT_EQ(cube.face_vertex_indices, before.face_vertex_indices);
}

}  // namespace
}  // namespace alabaster
