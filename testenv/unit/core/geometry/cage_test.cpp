#include "core/geometry/cage.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "core/geometry/mesh.h"
#include "testenv/support/cages.h"

namespace alabaster {
namespace {

using test::cube_cage;
using test::RecordingSink;

constexpr float kNotANumber = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

struct BadInput {
  const char* name;
  std::function<void(Cage&)> spoil;
  const char* code;
  size_t faces_left;
};

// GoogleTest prints parameters by their bytes otherwise.
void PrintTo(const BadInput& input, std::ostream* out) {
  *out << input.name;
}

class BadCage : public ::testing::TestWithParam<BadInput> {};

// OpenSubdiv or Embree reads out of bounds, hangs, or spreads the damage on each of these.
TEST_P(BadCage, IsReportedAndMadeSafe) {
  for (SubdivisionScheme scheme : {SubdivisionScheme::catmull_clark, SubdivisionScheme::bilinear}) {
    Cage cage = cube_cage(scheme);
    GetParam().spoil(cage);
    RecordingSink sink;
    EXPECT_EQ(sanitize_cage(cage, "cube", sink.sink()), GetParam().faces_left > 0);
    EXPECT_TRUE(sink.has(GetParam().code)) << GetParam().code;
    for (const Diagnostic& d : sink.all()) EXPECT_EQ(d.where, "cube");
    EXPECT_EQ(cage.face_vertex_counts.size(), GetParam().faces_left);
    for (int level : {0, 2}) {
      RefinementOptions options;
      options.level = level;
      const Mesh mesh = build_mesh(cage, options, {});
      EXPECT_EQ(mesh.triangles.empty(), GetParam().faces_left == 0);
      for (const auto& t : mesh.triangles)
        for (uint32_t i : t) EXPECT_TRUE(is_finite(mesh.points.at(i)));
      for (const UvSet& set : mesh.uv_sets)
        for (const Vec2f& uv : set.values) EXPECT_TRUE(is_finite(Vec3f(uv.x, uv.y, 0)));
    }
    // Safe values are unchanged.
    RecordingSink again;
    const bool drawable = sanitize_cage(cage, "cube", again.sink());
    EXPECT_EQ(drawable, GetParam().faces_left > 0);
    EXPECT_EQ(again.all().size(), drawable ? 0u : 1u);
  }
}

void add_face(Cage& cage, std::vector<int> corners) {
  cage.face_vertex_counts.push_back(static_cast<int>(corners.size()));
  cage.face_vertex_indices.insert(cage.face_vertex_indices.end(), corners.begin(), corners.end());
}

void crease(Cage& cage, std::vector<int> points, float sharpness) {
  cage.crease_lengths = {static_cast<int>(points.size())};
  cage.crease_indices = std::move(points);
  cage.crease_sharpnesses = {sharpness};
}

// A fan of n triangles about one point.
void fan(Cage& cage, int n) {
  cage.face_vertex_counts.clear();
  cage.face_vertex_indices.clear();
  cage.points = {{0, 0, 1}};
  for (int i = 0; i < n; ++i) {
    const float angle = kTwoPi * static_cast<float>(i) / static_cast<float>(n);
    cage.points.emplace_back(std::cos(angle), std::sin(angle), 0.0f);
    add_face(cage, {0, 1 + i, 1 + (i + 1) % n});
  }
}

void polygon(Cage& cage, int n) {
  fan(cage, n);
  cage.face_vertex_counts = {n};
  cage.face_vertex_indices.clear();
  for (int i = 0; i < n; ++i) cage.face_vertex_indices.push_back(1 + i);
}

std::vector<UvPrimvar> uvs(Interpolation interpolation, size_t n) {
  return {{{interpolation, std::vector<Vec2f>(n, Vec2f(0.5f, 0.25f)), {}}, "st"}};
}

INSTANTIATE_TEST_SUITE_P(
    Rows, BadCage,
    ::testing::Values(
        BadInput{"empty_face", [](Cage& c) { add_face(c, {}); }, "mesh.faces.small", 6},
        BadInput{"one_corner", [](Cage& c) { add_face(c, {0}); }, "mesh.faces.small", 6},
        BadInput{"two_corners",
                 [](Cage& c) {
                   add_face(c, {0, 1});
                 },
                 "mesh.faces.small", 6},
        BadInput{"negative_size", [](Cage& c) { c.face_vertex_counts.push_back(-4); }, "mesh.faces.small", 6},
        BadInput{"counts_beyond_indices", [](Cage& c) { c.face_vertex_counts.push_back(4); }, "mesh.faces.short", 6},
        BadInput{"huge_counts", [](Cage& c) { c.face_vertex_counts.assign(6, 2147483647); }, "mesh.faces.large", 0},
        BadInput{"spare_indices", [](Cage& c) { c.face_vertex_indices.push_back(3); }, "mesh.faces.long", 6},
        BadInput{"no_faces", [](Cage& c) { c.face_vertex_counts.clear(); }, "mesh.empty", 0},
        BadInput{"no_points", [](Cage& c) { c.points.clear(); }, "mesh.faces.index", 0},
        BadInput{"index_is_size", [](Cage& c) { c.face_vertex_indices[0] = 8; }, "mesh.faces.index", 5},
        BadInput{"index_1e8", [](Cage& c) { c.face_vertex_indices[0] = 100000000; }, "mesh.faces.index", 5},
        BadInput{"index_negative", [](Cage& c) { c.face_vertex_indices[23] = -1; }, "mesh.faces.index", 5},
        BadInput{"point_nan", [](Cage& c) { c.points[0].y = kNotANumber; }, "mesh.points.nonfinite", 3},
        BadInput{"point_inf", [](Cage& c) { c.points[7].x = -kInfinity; }, "mesh.points.nonfinite", 3},
        BadInput{"point_far", [](Cage& c) { c.points[7].x = 1e30f; }, "mesh.points.nonfinite", 3},
        BadInput{"large_face", [](Cage& c) { polygon(c, 2000); }, "mesh.faces.size", 1},
        BadInput{"huge_face", [](Cage& c) { polygon(c, 40000); }, "mesh.faces.large", 0},
        BadInput{"valence", [](Cage& c) { fan(c, 40000); }, "mesh.points.valence", 40000},
        BadInput{"hole_beyond", [](Cage& c) { c.hole_indices = {6}; }, "mesh.holes.index", 6},
        BadInput{"hole_negative", [](Cage& c) { c.hole_indices = {-1}; }, "mesh.holes.index", 6},
        BadInput{"crease_beyond",
                 [](Cage& c) {
                   crease(c, {0, 99}, 2);
                 },
                 "mesh.creases.edge", 6},
        BadInput{"crease_negative",
                 [](Cage& c) {
                   crease(c, {-1, 0}, 2);
                 },
                 "mesh.creases.edge", 6},
        BadInput{"crease_no_edge",
                 [](Cage& c) {
                   crease(c, {0, 7}, 2);
                 },
                 "mesh.creases.edge", 6},
        BadInput{"crease_one_point", [](Cage& c) { crease(c, {0}, 2); }, "mesh.creases.size", 6},
        BadInput{"crease_no_sharpness",
                 [](Cage& c) {
                   crease(c, {0, 1}, 2);
                   c.crease_sharpnesses.clear();
                 },
                 "mesh.creases.size", 6},
        BadInput{"crease_long",
                 [](Cage& c) {
                   crease(c, {0, 1}, 2), c.crease_lengths = {2147483647};
                 },
                 "mesh.creases.size", 6},
        BadInput{"crease_nan",
                 [](Cage& c) {
                   crease(c, {0, 1}, kNotANumber);
                 },
                 "mesh.creases.sharpness", 6},
        BadInput{"crease_below_zero",
                 [](Cage& c) {
                   crease(c, {0, 1}, -1);
                 },
                 "mesh.creases.sharpness", 6},
        BadInput{"corner_beyond", [](Cage& c) { c.corner_indices = {8}, c.corner_sharpnesses = {1}; },
                 "mesh.corners.index", 6},
        BadInput{"corner_nan", [](Cage& c) { c.corner_indices = {0}, c.corner_sharpnesses = {kNotANumber}; },
                 "mesh.corners.sharpness", 6},
        BadInput{"corner_no_sharpness", [](Cage& c) { c.corner_indices = {0}; }, "mesh.corners.size", 6},
        BadInput{"uv_short", [](Cage& c) { c.uvs = uvs(Interpolation::face_varying, 23); }, "mesh.uv.size", 6},
        BadInput{"uv_vertex_short", [](Cage& c) { c.uvs = uvs(Interpolation::vertex, 7); }, "mesh.uv.size", 6},
        BadInput{"uv_constant_two", [](Cage& c) { c.uvs = uvs(Interpolation::constant, 2); }, "mesh.uv.size", 6},
        BadInput{"uv_uniform_short", [](Cage& c) { c.uvs = uvs(Interpolation::uniform, 5); }, "mesh.uv.size", 6},
        BadInput{"uv_varying_long", [](Cage& c) { c.uvs = uvs(Interpolation::varying, 9); }, "mesh.uv.size", 6},
        BadInput{"invisible_beyond", [](Cage& c) { c.invisible_faces = {6, -1}; }, "mesh.invisible.index", 6},
        BadInput{"uv_index_beyond",
                 [](Cage& c) {
                   c.uvs = uvs(Interpolation::face_varying, 4);
                   c.uvs[0].indices.assign(24, 4);
                 },
                 "mesh.uv.index", 6},
        BadInput{"uv_index_negative",
                 [](Cage& c) {
                   c.uvs = uvs(Interpolation::face_varying, 4);
                   c.uvs[0].indices.assign(24, -1);
                 },
                 "mesh.uv.index", 6},
        BadInput{"uv_nan",
                 [](Cage& c) {
                   c.uvs = uvs(Interpolation::vertex, 8);
                   c.uvs[0].values[3].y = kNotANumber;
                 },
                 "mesh.uv.nonfinite", 6},
        BadInput{"normals_short", [](Cage& c) { c.normals.values.assign(3, Vec3f(0, 0, 1)); }, "mesh.normals.size", 6},
        BadInput{"material_short", [](Cage& c) { c.face_material = {1}; }, "mesh.material.size", 6},
        BadInput{"material_negative", [](Cage& c) { c.face_material.assign(6, -2); }, "mesh.material.slot", 6},
        BadInput{"only_holes",
                 [](Cage& c) {
                   c.face_vertex_counts = {4}, c.face_vertex_indices.resize(4);
                   c.points[0].x = kInfinity;
                 },
                 "mesh.empty", 0}),
    [](const testing::TestParamInfo<BadInput>& info) { return std::string(info.param.name); });

TEST(SanitizeCage, FaultsOfOneKindAreReportedOnceWithCountAndFirst) {
  Cage cage = cube_cage();
  cage.face_vertex_indices[4] = 77;   // face 1
  cage.face_vertex_indices[13] = -5;  // face 3
  RecordingSink sink;
  EXPECT_TRUE(sanitize_cage(cage, "file.glb mesh 2", sink.sink()));
  ASSERT_EQ(sink.all().size(), 1u);
  EXPECT_EQ(sink.all()[0].text, "2 faces use points that do not exist; dropped (first: face 1)");
}

TEST(SanitizeCage, ConstantAndUniformValuesAreSpread) {
  Cage cage = cube_cage();
  cage.uvs = uvs(Interpolation::uniform, 6);
  cage.primvars = {{Primvar<float>{Interpolation::constant, {0.25f, 0.5f}, {1}}, "wetness"}};
  cage.face_vertex_indices[0] = -1;  // face 0 goes
  cage.invisible_faces = {0, 5, 2};
  EXPECT_TRUE(sanitize_cage(cage, "", {}));
  const auto& wetness = std::get<Primvar<float>>(cage.primvars[0].values);
  EXPECT_EQ(wetness.interpolation, Interpolation::vertex);
  EXPECT_EQ(wetness.indices, std::vector<int>(8, 1));
  EXPECT_EQ(cage.uvs[0].interpolation, Interpolation::face_varying);
  ASSERT_EQ(cage.uvs[0].indices.size(), 20u);
  for (size_t corner = 0; corner < 20; ++corner) EXPECT_EQ(cage.uvs[0].indices[corner], int(corner / 4) + 1);
  EXPECT_EQ(cage.invisible_faces, (std::vector<int>{1, 4})) << "by their new numbers";
}

TEST(SanitizeCage, PerFaceValuesFollowRemovedFaces) {
  Cage cage = cube_cage();
  cage.face_material = {0, 1, 2, 3, 4, 5};
  cage.hole_indices = {4, 1, 4};
  cage.uvs.resize(1);
  cage.uvs[0].interpolation = Interpolation::face_varying;
  for (int i = 0; i < 24; ++i) cage.uvs[0].values.emplace_back(static_cast<float>(i), 0.0f);
  cage.face_vertex_indices[0] = -1;
  EXPECT_TRUE(sanitize_cage(cage, "", {}));
  EXPECT_EQ(cage.face_material, (std::vector<int>{1, 2, 3, 4, 5}));
  EXPECT_EQ(cage.hole_indices, (std::vector<int>{0, 3}));
  ASSERT_EQ(cage.uvs[0].values.size(), 20u);
  EXPECT_EQ(cage.uvs[0].values[0].x, 4.0f);
}

TEST(SanitizeCage, HolesAloneLeaveNothingToDraw) {
  Cage cage = cube_cage();
  cage.hole_indices = {0, 1, 2, 3, 4, 5};
  EXPECT_FALSE(sanitize_cage(cage, "", {}));
}

TEST(SanitizeCage, LoopOverQuadsFallsBack) {
  Cage cage = cube_cage(SubdivisionScheme::loop);
  RecordingSink sink;
  EXPECT_TRUE(sanitize_cage(cage, "", sink.sink()));
  EXPECT_TRUE(sink.has("mesh.scheme.loop"));
  EXPECT_EQ(cage.scheme, SubdivisionScheme::catmull_clark);
}

TEST(SanitizeCage, GoodCreasesSurviveBadNeighbours) {
  Cage cage = cube_cage(SubdivisionScheme::catmull_clark);
  cage.crease_indices = {0, 1, 3, 4, 7, 5};  // 0-1-3 are edges; 4-7 is a diagonal, 7-5 an edge
  cage.crease_lengths = {3, 3};
  cage.crease_sharpnesses = {2, 12};
  EXPECT_TRUE(sanitize_cage(cage, "", {}));
  EXPECT_EQ(cage.crease_indices, (std::vector<int>{0, 1, 1, 3, 7, 5}));
  EXPECT_EQ(cage.crease_lengths, (std::vector<int>{2, 2, 2}));
  EXPECT_EQ(cage.crease_sharpnesses, (std::vector<float>{2, 2, 10}));
}

// Accepted as they are by OpenSubdiv: they must come out finite.
TEST(SanitizeCage, OddTopologyIsDrawn) {
  const std::vector<std::vector<int>> extra = {{0, 1, 5, 4},   // a face twice
                                               {0, 4, 5, 1},   // ... and turned over
                                               {0, 1, 6},      // a third face on an edge
                                               {0, 1, 1, 5},   // a repeated corner
                                               {2, 2, 2, 2},   // no area at all
                                               {0, 5, 1, 4}};  // a bow tie
  for (const auto& face : extra)
    for (SubdivisionScheme scheme : {SubdivisionScheme::catmull_clark, SubdivisionScheme::bilinear}) {
      Cage cage = cube_cage(scheme);
      add_face(cage, face);
      ASSERT_TRUE(sanitize_cage(cage, "", {}));
      RefinementOptions options;
      options.level = 2;
      const Mesh mesh = build_mesh(cage, options, {});
      EXPECT_GE(mesh.triangles.size(), 6u * 32u);
      for (const Vec3f& p : mesh.points) EXPECT_TRUE(is_finite(p));
      for (const Vec3f& n : mesh.normals) EXPECT_TRUE(is_finite(n));
    }
}

}  // namespace
}  // namespace alabaster
