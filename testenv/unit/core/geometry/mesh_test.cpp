#include "core/geometry/mesh.h"

#include <gtest/gtest.h>

#include <bit>
#include <chrono>
#include <ctime>
#include <map>
#include <random>
#include <set>

#include "core/geometry/reversed_edges.h"
#include "core/geometry/triangulation.h"
#include "testenv/support/cages.h"

namespace alabaster {
namespace {

Cage polygon_cage(const std::vector<Vec3f>& points) {
  Cage cage;
  cage.points = points;
  cage.face_vertex_counts = {static_cast<int>(points.size())};
  for (size_t i = 0; i < points.size(); ++i) cage.face_vertex_indices.push_back(static_cast<int>(i));
  return cage;
}

Vec3f doubled_area(const Mesh& mesh, size_t t) {
  const auto& c = mesh.triangles[t];
  return cross(mesh.points[c[1]] - mesh.points[c[0]], mesh.points[c[2]] - mesh.points[c[0]]);
}

// All triangles face the polygon's way and their areas add up to its own: nothing folds over.
void expect_exact_cover(const Cage& cage, const Vec3f& doubled) {
  const Mesh mesh = build_mesh(cage, {}, {});
  ASSERT_EQ(mesh.triangles.size(), cage.points.size() - 2);
  Vec3f sum(0, 0, 0);
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    EXPECT_GE(dot(doubled_area(mesh, t), doubled), 0);
    sum += doubled_area(mesh, t);
  }
  EXPECT_NEAR(length(sum - doubled), 0, 1e-5f * length(doubled));
}

TEST(Triangulation, ConcavePolygonsDoNotFoldOver) {
  expect_exact_cover(polygon_cage({{0, 0, 0}, {2, 1, 0}, {0, 2, 0}, {1, 1, 0}}), {0, 0, 2});  // dart, notch at 3
  expect_exact_cover(polygon_cage({{1, 1, 0}, {0, 0, 0}, {2, 1, 0}, {0, 2, 0}}), {0, 0, 2});  // notch at 0
  const std::vector<Vec3f> comb = {{0, 0, 0}, {7, 0, 0}, {7, 3, 0}, {6, 3, 0}, {6, 1, 0}, {5, 1, 0},
                                   {5, 3, 0}, {4, 3, 0}, {4, 1, 0}, {3, 1, 0}, {3, 3, 0}, {0, 3, 0}};
  expect_exact_cover(polygon_cage(comb), {0, 0, 34});
  // The other way round, and in another plane.
  std::vector<Vec3f> turned;
  for (auto p = comb.rbegin(); p != comb.rend(); ++p) turned.emplace_back(p->x, p->x - p->y, p->y);
  Vec3f doubled(0, 0, 0);
  for (size_t i = 0; i < turned.size(); ++i) doubled += cross(turned[i], turned[(i + 1) % turned.size()]);
  expect_exact_cover(polygon_cage(turned), doubled);
  std::vector<Vec3f> star;
  for (int i = 0; i < 300; ++i) {
    const float angle = kTwoPi * static_cast<float>(i) / 300, radius = i % 2 ? 1.0f : 0.3f;
    star.emplace_back(radius * std::cos(angle), radius * std::sin(angle), 5.0f);
  }
  doubled = Vec3f(0, 0, 300 * 0.3f * std::sin(kTwoPi / 300));
  expect_exact_cover(polygon_cage(star), doubled);
}

// A polygon that intersects itself all over has few ears: a search for each one took minutes.
// promise: security.no_time
TEST(Triangulation, NoPolygonIsSlow) {
  constexpr int kCorners = 30000;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::vector<Vec3d> star, tangle;
  for (int i = 0; i < kCorners; ++i) {
    const double angle = 2 * kPiDouble * i / kCorners, radius = i % 2 ? 1 : 0.7 + 0.2 * uniform(random);
    star.emplace_back(radius * std::cos(angle), radius * std::sin(angle), 0);
    tangle.emplace_back(uniform(random), uniform(random), 0);
  }
  const auto seconds = [](const std::vector<Vec3d>& corners) {
    std::vector<std::array<int, 3>> triangles;
    const std::clock_t start = std::clock();
    triangulate_polygon(corners, &triangles);
    EXPECT_EQ(triangles.size(), corners.size() - 2);
    return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  };
  const double usual = seconds(star);
  EXPECT_LT(seconds(tangle), 20 * usual + 1);
}

TEST(Triangulation, CollinearCornersAreCovered) {
  expect_exact_cover(polygon_cage({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 2, 0}, {1, 0.5f, 0}, {0, 2, 0}}), {0, 0, 5});
}

TEST(Triangulation, ConvexPolygonsAreFansFromTheirFirstCorner) {
  Cage cage = test::cube_cage();
  const Mesh mesh = build_mesh(cage, {}, {});
  ASSERT_EQ(mesh.triangles.size(), 12u);
  // 0, 2, 3 and 0, 3, 1, turned to be a pair.
  EXPECT_EQ(mesh.triangles[0], (std::array<uint32_t, 3>{2, 3, 0}));
  EXPECT_EQ(mesh.triangles[1], (std::array<uint32_t, 3>{1, 0, 3}));
  EXPECT_EQ(mesh.triangle_face[11], 5);
  EXPECT_TRUE(mesh.normals.empty());  // scheme none: flat
  EXPECT_TRUE(mesh.closed);
  EXPECT_TRUE(mesh.outward);
  cage.left_handed = !cage.left_handed;
  EXPECT_FALSE(build_mesh(cage, {}, {}).outward) << "turned inside out";
  EXPECT_EQ(mesh.bounds.lower, Vec3f(-1, -1, -1));
  EXPECT_EQ(mesh.bounds.upper, Vec3f(1, 1, 1));
}

TEST(Mesh, SmoothNormalsAreWeightedByArea) {
  for (float scale : {0x1p-20f, 1.0f, 0x1p20f}) {
    Cage cage = test::cube_cage(SubdivisionScheme::catmull_clark);
    for (Vec3f& p : cage.points) p = Vec3f(p.x * 3, p.y * 2, p.z) * scale;
    const Mesh mesh = build_mesh(cage, {}, {});
    // Areas of the faces along x, y, z: 2 x 1, 3 x 1, 3 x 2.
    const Vec3f expected = normalize(Vec3f(2, 3, 6));
    EXPECT_NEAR(length(mesh.normals[7] - expected), 0, 1e-6f);
    EXPECT_NEAR(length(mesh.normals[0] + expected), 0, 1e-6f);
  }
}

TEST(Mesh, AuthoredAttributesAreFoundThroughTheirIndices) {
  Cage cage = test::cube_cage(SubdivisionScheme::catmull_clark);
  cage.normals = {Interpolation::face_varying, {{0, 0, 1}, {0, 1, 0}}, std::vector<int>(24, 1)};
  cage.normals.indices[2] = 0;
  cage.uvs.resize(1);
  for (int i = 0; i < 8; ++i) cage.uvs[0].values.emplace_back(static_cast<float>(i), 0.0f);
  cage.face_material = {0, 3, 0, 0, 0, 0};
  const Mesh mesh = build_mesh(cage, {}, {});
  EXPECT_EQ(mesh.normal_triangles[0], (std::array<uint32_t, 3>{1, 0, 1}));  // of the face's corners 1, 2, 0
  EXPECT_EQ(mesh.normals[0], Vec3f(0, 0, 1));
  EXPECT_TRUE(mesh.uv_sets[0].triangles.empty());
  EXPECT_EQ(mesh.triangle_material[2], 3);
  EXPECT_EQ(mesh.triangle_material[4], 0);
}

TEST(Mesh, WeldJoinsEqualBitsOnly) {
  const float next = std::nextafter(1.0f, 2.0f);
  EXPECT_EQ(weld_by_position({{1, 0, 2}, {next, 0, 2}, {1, -0.0f, 2}, {next, 0, 2}, {0, 1, 2}}),
            (std::vector<int>{0, 1, 0, 1, 4}));
  EXPECT_TRUE(weld_by_position({}).empty());
}

// These points share their slots in a table of hashes that mix well: an earlier version took time with their square.
TEST(Mesh, NoChoiceOfPointsMakesWeldingSlow) {
  std::vector<Vec3f> collide, ordinary;
  for (uint32_t bits = 0x3e800000; collide.size() < 60000; ++bits) {
    const Vec3f p(0.5f, 0.25f, std::bit_cast<float>(bits));
    uint64_t h = std::bit_cast<uint32_t>(p.x) * 0x9e3779b97f4a7c15ull;
    h = (h ^ (h >> 29) ^ std::bit_cast<uint32_t>(p.y)) * 0xbf58476d1ce4e5b9ull;
    h = (h ^ (h >> 32) ^ bits) * 0x94d049bb133111ebull;
    h ^= h >> 31;
    if ((h & 0x1ffff) < 64) collide.push_back(p);
    if (ordinary.size() < 60000) ordinary.push_back(p);
  }
  const auto seconds = [](const std::vector<Vec3f>& points) {
    const auto start = std::chrono::steady_clock::now();
    EXPECT_EQ(weld_by_position(points).size(), points.size());
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  const double usual = seconds(ordinary);
  EXPECT_LT(seconds(collide), 20 * usual + 0.3);
}

TEST(Mesh, ClosedMeansEveryEdgeIsPairedAfterWelding) {
  Cage split = test::cube_cage();  // every face with points of its own
  std::vector<Vec3f> points;
  for (int& i : split.face_vertex_indices) {
    points.push_back(split.points[static_cast<size_t>(i)]);
    i = static_cast<int>(points.size()) - 1;
  }
  split.points = points;
  EXPECT_TRUE(build_mesh(split, {}, {}).closed);
  split.points[0].x = std::nextafter(split.points[0].x, 0.0f);
  EXPECT_FALSE(build_mesh(split, {}, {}).closed);
  Cage open = test::cube_cage();
  open.hole_indices = {2};
  EXPECT_FALSE(build_mesh(open, {}, {}).closed);
  EXPECT_FALSE(build_mesh(test::grid_cage(2), {}, {}).closed);
  EXPECT_FALSE(build_mesh(Cage(), {}, {}).closed);
  // Two cubes that touch along an edge: four faces meet there.
  Cage pair = test::cube_cage();
  for (const Vec3f& p : test::cube_cage().points) pair.points.push_back(p + Vec3f(2, 2, 0));
  for (int i : test::cube_cage().face_vertex_indices) pair.face_vertex_indices.push_back(i + 8);
  pair.face_vertex_counts.assign(12, 4);
  EXPECT_TRUE(build_mesh(pair, {}, {}).closed);
  // A flap on an edge: three faces there.
  Cage flap = test::cube_cage();
  flap.points.emplace_back(5.0f, 5.0f, 5.0f);
  flap.face_vertex_counts.push_back(3);
  flap.face_vertex_indices.insert(flap.face_vertex_indices.end(), {5, 7, 8});
  EXPECT_FALSE(build_mesh(flap, {}, {}).closed);
}

// `turn`: by how many corners each face of `more` begins later.
Cage with_faces(Cage cage, const Cage& more, bool reversed, int turn = 0) {
  size_t first = 0;
  const auto offset = static_cast<int>(cage.points.size());
  cage.points.insert(cage.points.end(), more.points.begin(), more.points.end());
  for (const int count : more.face_vertex_counts) {
    const auto begin = more.face_vertex_indices.begin() + static_cast<std::ptrdiff_t>(first);
    std::vector<int> face(begin, begin + count);
    if (reversed) std::reverse(face.begin() + 1, face.end());
    std::rotate(face.begin(), face.begin() + turn, face.end());
    cage.face_vertex_counts.push_back(count);
    for (const int i : face) cage.face_vertex_indices.push_back(i + offset);
    first += static_cast<size_t>(count);
  }
  return cage;
}

// Walks, glass and warnings ask one notion: a sheet is open, however often its faces are there.
TEST(Mesh, DoubledSheetsAreOpenAndDoubledBodiesAreClosed) {
  const Cage cube = test::cube_cage(), sheet = test::grid_cage(2);
  for (const bool reversed : {false, true}) {
    EXPECT_TRUE(build_mesh(with_faces(cube, cube, reversed), {}, {}).closed) << reversed;
    const Mesh doubled = build_mesh(with_faces(sheet, sheet, reversed), {}, {});
    EXPECT_FALSE(doubled.closed) << reversed;
    const OpenEdges edges = find_open_edges(doubled), single = find_open_edges(build_mesh(sheet, {}, {}));
    EXPECT_EQ(edges.of_one.count, single.of_one.count) << reversed;
    EXPECT_EQ(edges.of_one.first, single.of_one.first) << reversed;
    EXPECT_EQ(edges.of_more.count, 0u) << reversed;
  }
  // The doubled faces may share the points of the first ones.
  Cage shared = with_faces(sheet, sheet, true);
  shared.points = sheet.points;
  for (int& i : shared.face_vertex_indices) i %= static_cast<int>(sheet.points.size());
  const Mesh mesh = build_mesh(shared, {}, {});
  EXPECT_FALSE(mesh.closed);
  EXPECT_FALSE(mesh.sealed);
}

/// True if each triangle has one or more others with the same corners.
bool are_all_doubled(const Mesh& mesh) {
  const std::vector<int> weld = weld_by_position(mesh.points);
  std::map<std::set<int>, int> count;
  for (const Corners& t : mesh.triangles) ++count[{weld[t[0]], weld[t[1]], weld[t[2]]}];
  return std::all_of(count.begin(), count.end(), [](const auto& entry) { return entry.second % 2 == 0; });
}

// Faces are authored, triangles are not: a quad and its reverse coincide, wherever the corners of each begin.
TEST(Mesh, DoubledFacesThatBeginAtAnotherCornerAreCutAlike) {
  const Cage cube = test::cube_cage(), sheet = test::grid_cage(2);
  Cage concave;  // the ears of a polygon depend on where it begins
  concave.points = {{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {2, 1, 0}, {0, 4, 0}};
  concave.face_vertex_counts = {5};
  concave.face_vertex_indices = {0, 1, 2, 3, 4};
  for (const bool reversed : {false, true})
    for (const bool left_handed : {false, true})
      for (const int turn : {1, 2, 3}) {
        Cage doubled = with_faces(sheet, sheet, reversed, turn), body = with_faces(cube, cube, reversed, turn);
        doubled.left_handed = body.left_handed = left_handed;
        for (const bool shares_points : {false, true}) {
          if (shares_points)
            for (int& i : doubled.face_vertex_indices) i %= static_cast<int>(sheet.points.size());
          const Mesh mesh = build_mesh(doubled, {}, {});
          EXPECT_TRUE(are_all_doubled(mesh)) << turn;
          EXPECT_FALSE(mesh.closed) << turn;
          EXPECT_EQ(find_open_edges(mesh).of_one.count, 8u) << turn;
        }
        const Mesh mesh = build_mesh(body, {}, {});
        EXPECT_TRUE(are_all_doubled(mesh)) << turn;
        EXPECT_TRUE(mesh.closed) << turn;
        EXPECT_EQ(find_reversed_edges(mesh).count, 0u) << turn;
        EXPECT_TRUE(are_all_doubled(build_mesh(with_faces(concave, concave, reversed, turn), {}, {}))) << turn;
        // Each face keeps its winding: the volumes of two bodies cancel or add up.
        double volume = 0;
        for (const Corners& t : mesh.triangles)
          volume += dot(Vec3d(mesh.points[t[0]]), cross(Vec3d(mesh.points[t[1]]), Vec3d(mesh.points[t[2]]))) / 6;
        EXPECT_NEAR(std::abs(volume), reversed ? 0 : 16, 1e-6) << turn;
      }
}

TEST(Mesh, ReversedEdgesAreThoseAroundTurnedFaces) {
  Cage cube = test::cube_cage();
  EXPECT_EQ(find_reversed_edges(build_mesh(cube, {}, {})).count, 0u);
  std::reverse(cube.face_vertex_indices.begin() + 8, cube.face_vertex_indices.begin() + 12);
  const Mesh turned = build_mesh(cube, {}, {});
  EXPECT_TRUE(turned.closed);
  EXPECT_EQ(find_reversed_edges(turned).count, 4u);
  EXPECT_EQ(find_open_edges(turned).of_one.count, 0u);
  EXPECT_EQ(find_reversed_edges(build_mesh(with_faces(test::cube_cage(), test::cube_cage(), true), {}, {})).count, 0u);
  EXPECT_EQ(find_reversed_edges(build_mesh(test::grid_cage(2), {}, {})).count, 0u) << "open edges are no reversed ones";
}

// The pose of a mesh is the mesh of the posed cage.
TEST(PoseMesh, IsTheMeshOfThePosedCage) {
  for (const auto scheme : {SubdivisionScheme::none, SubdivisionScheme::catmull_clark})
    for (const int level : {0, 2})
      for (const bool authored : {false, true}) {
        Cage cage = test::cube_cage();
        cage.scheme = scheme;
        cage.normals = {};
        if (authored) cage.normals.values = cage.points;
        Cage posed = cage;
        for (Vec3f& p : posed.points) p = {p.x * 2 + p.y, p.y, p.z - p.x * p.y};
        if (authored) posed.normals.values = posed.points;
        RefinementOptions options;
        options.level = level;
        const Mesh rest = build_mesh(cage, options, {}), expected = build_mesh(posed, options, {});
        const MeshPose pose = pose_mesh(cage, options, {posed.points, posed.normals.values});
        EXPECT_EQ(pose.points, expected.points);
        EXPECT_EQ(pose.normals, expected.normals);
        EXPECT_EQ(pose.points.size(), rest.points.size());
        EXPECT_EQ(pose.normals.size(), rest.normals.size());
      }
}

TEST(PoseMesh, WithTheMeshBeforeIsClosedAsItIsWithoutIt) {
  Cage cage = test::cube_cage();
  const Mesh before = build_mesh(cage, {}, {});
  EXPECT_TRUE(before.sealed);
  RefinementOptions options;
  options.before = &before;
  cage.points[0] = {-2, -2, -2};
  EXPECT_TRUE(build_mesh(cage, options, {}).sealed);
  cage.invisible_faces = {2};  // other triangles
  const Mesh open = build_mesh(cage, options, {});
  EXPECT_FALSE(open.closed);
  // A face with corners of its own, which meet the others' by position.
  cage = test::cube_cage();
  for (int i = 0; i < 4; ++i) {
    cage.points.push_back(cage.points[static_cast<size_t>(cage.face_vertex_indices[static_cast<size_t>(i)])]);
    cage.face_vertex_indices[static_cast<size_t>(i)] = 8 + i;
  }
  const Mesh welded = build_mesh(cage, options, {});
  EXPECT_TRUE(welded.closed);
  EXPECT_FALSE(welded.sealed);
  options.before = &welded;
  cage.points[8] *= 2.0f;
  EXPECT_FALSE(build_mesh(cage, options, {}).closed);
}

}  // namespace
}  // namespace alabaster
