// Normals and tangents that cannot be used, and faces that have a point twice.
#include <gtest/gtest.h>

#include <limits>
#include <optional>

#include "core/geometry/tangents.h"
#include "testenv/support/cages.h"

namespace alabaster {
namespace {

using test::cube_cage;
using test::RecordingSink;

/// The unit square of two triangles, with normals, texture coordinates and tangents of its points.
Cage square() {
  Cage cage;
  cage.points = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  cage.face_vertex_counts = {3, 3};
  cage.face_vertex_indices = {0, 1, 2, 0, 2, 3};
  cage.scheme = SubdivisionScheme::none;
  cage.normals = {Interpolation::vertex, std::vector<Vec3f>(4, Vec3f(0, 0, 1)), {}};
  cage.tangents = {Interpolation::vertex, std::vector<Vec4f>(4, Vec4f(0, 1, 0, 1)), {}};
  cage.uvs = {{{Interpolation::vertex, {{0, 0}, {1, 0}, {1, 1}, {0, 1}}, {}}, "st"}};
  return cage;
}

Mesh built(Cage cage, RecordingSink* sink) {
  EXPECT_TRUE(sanitize_cage(cage, "square", sink->sink()));
  RefinementOptions options;
  options.where = "square";
  return build_mesh(cage, options, sink->sink());
}

/// The tangents at a point, of all corners there, which are the same.
Vec4f tangent_at(const Mesh& mesh, uint32_t point) {
  const auto& corners = mesh.tangents.triangles.empty() ? mesh.triangles : mesh.tangents.triangles;
  std::optional<Vec4f> found;
  for (size_t t = 0; t < mesh.triangles.size(); ++t)
    for (size_t i = 0; i < 3; ++i) {
      if (mesh.triangles[t][i] != point) continue;
      const Vec4f& tangent = mesh.tangents.values[corners[t][i]];
      EXPECT_EQ(found.value_or(tangent), tangent);
      found = tangent;
    }
  return found.value_or(Vec4f(0));
}

TEST(MendVectors, LeavesUsableOnesAlone) {
  RecordingSink sink;
  const Mesh mesh = built(square(), &sink);
  EXPECT_TRUE(sink.all().empty());
  EXPECT_EQ(tangent_at(mesh, 0), Vec4f(0, 1, 0, 1));
}

TEST(MendVectors, NormalsOfZeroAreThoseOfTheFaces) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const Vec3f& bad : {Vec3f(0, 0, 0), Vec3f(nan, 0, 1)}) {
    Cage cage = square();
    cage.normals.values[0] = cage.normals.values[3] = bad;
    cage.normals.values[1] = Vec3f(0.6f, 0, 0.8f);
    RecordingSink sink;
    const Mesh mesh = built(cage, &sink);
    EXPECT_EQ(mesh.normals[0], Vec3f(0, 0, 1));
    EXPECT_EQ(mesh.normals[3], Vec3f(0, 0, 1));
    EXPECT_EQ(mesh.normals[1], Vec3f(0.6f, 0, 0.8f));
    EXPECT_TRUE(sink.has("mesh.normals.unusable"));
  }
  // By corners: each face has its own.
  Cage cage = cube_cage(SubdivisionScheme::none);
  cage.normals = {Interpolation::face_varying, std::vector<Vec3f>(24, Vec3f(0, 0, 0)), {}};
  RecordingSink sink;
  const Mesh mesh = built(cage, &sink);
  for (size_t t = 0; t < mesh.triangles.size(); ++t)
    for (size_t i = 0; i < 3; ++i) {
      const auto& p = mesh.triangles[t];
      const Vec3f face = cross(mesh.points[p[1]] - mesh.points[p[0]], mesh.points[p[2]] - mesh.points[p[0]]);
      EXPECT_NEAR(length(mesh.normals[mesh.normal_triangles[t][i]] - face * (1 / length(face))), 0, 1e-6f);
    }
}

TEST(MendVectors, UnusableTangentsAreThoseOfTheCoordinates) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const Vec4f& bad :
       {Vec4f(0, 0, 0, 1), Vec4f(0, 0, 0, 0), Vec4f(nan, 1, 0, 1), Vec4f(0, 0, 1, 1), Vec4f(0, 1, 0, 0)}) {
    Cage cage = square();
    cage.tangents.values[1] = bad;
    RecordingSink sink;
    const Mesh mesh = built(cage, &sink);
    EXPECT_TRUE(sink.has("mesh.tangents.unusable")) << bad;
    EXPECT_EQ(tangent_at(mesh, 1), Vec4f(1, 0, 0, 1)) << bad;
    for (const uint32_t point : {0u, 2u, 3u}) EXPECT_EQ(tangent_at(mesh, point), Vec4f(0, 1, 0, 1)) << "as authored";
    cage.tangents.values.assign(4, bad);
    EXPECT_TRUE(built(cage, &sink).tangents.empty()) << "without one, they are computed where a map asks for them";
  }
}

std::vector<Vec3f> corners_of(const Cage& cage) {
  RefinementOptions options;
  options.level = 2;
  const Mesh mesh = build_mesh(cage, options, {});
  std::vector<Vec3f> points;
  for (const auto& t : mesh.triangles)
    for (const uint32_t i : t) points.push_back(mesh.points[i]);
  return points;
}

// A face that has a point twice made a crease along its edges.
TEST(MendVectors, FacesThatHaveAPointTwiceDoNotCrease) {
  const Cage cube = cube_cage(SubdivisionScheme::catmull_clark);
  for (const std::vector<int>& face : {std::vector<int>{0, 0, 1}, {0, 1, 0}, {2, 2, 2}, {3, 1, 1, 3}}) {
    Cage more = cube;
    more.face_vertex_counts.push_back(int(face.size()));
    more.face_vertex_indices.insert(more.face_vertex_indices.end(), face.begin(), face.end());
    RecordingSink sink;
    ASSERT_TRUE(sanitize_cage(more, "cube", sink.sink()));
    EXPECT_TRUE(sink.has("mesh.faces.degenerate"));
    EXPECT_EQ(corners_of(more), corners_of(cube));
  }
  // A quad that is a triangle by its points keeps its other corners' values.
  Cage wedge;
  wedge.scheme = SubdivisionScheme::catmull_clark;
  wedge.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  wedge.face_vertex_counts = {4};
  wedge.face_vertex_indices = {0, 1, 1, 2};
  wedge.uvs = {{{Interpolation::face_varying, {{0, 0}, {1, 0}, {1, 1}, {0, 1}}, {}}, "st"}};
  RecordingSink sink;
  ASSERT_TRUE(sanitize_cage(wedge, "wedge", sink.sink()));
  EXPECT_EQ(wedge.face_vertex_counts, std::vector<int>{3});
  EXPECT_EQ(wedge.face_vertex_indices, (std::vector<int>{0, 1, 2}));
  ASSERT_EQ(wedge.uvs.size(), 1u);
  EXPECT_EQ(wedge.uvs[0].values, (std::vector<Vec2f>{{0, 0}, {1, 1}, {0, 1}}));
  Cage plain = wedge;
  plain.scheme = SubdivisionScheme::none;
  plain.face_vertex_counts = {4};
  plain.face_vertex_indices = {0, 1, 1, 2};
  plain.uvs.clear();
  ASSERT_TRUE(sanitize_cage(plain, "plain", sink.sink()));
  EXPECT_EQ(plain.face_vertex_counts, std::vector<int>{4}) << "only cages that are subdivided";
}

}  // namespace
}  // namespace alabaster
