#include "core/geometry/tangents.h"

#include <gtest/gtest.h>

namespace alabaster {
namespace {

// Two triangles of the unit square in the xy plane; `uv` of a point.
template <class Uv>
Mesh square(const Uv& uv) {
  Mesh mesh;
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.uv_sets.resize(1);
  mesh.uv_sets[0].name = "st";
  for (const Vec3f& p : mesh.points) mesh.uv_sets[0].values.push_back(uv(p));
  return mesh;
}

void expect_all(const MeshAttribute<Vec4f>& tangents, const Vec4f& expected) {
  ASSERT_EQ(tangents.triangles.size(), 2u);
  for (const Corners& corners : tangents.triangles)
    for (const uint32_t c : corners)
      for (int i = 0; i < 4; ++i) EXPECT_NEAR(tangents.values[c][i], expected[i], 1e-6f) << i;
}

TEST(Tangents, FollowUAndTellMirroredCoordinates) {
  const auto of = [](const Mesh& mesh) { return compute_tangents(mesh, mesh.uv_sets[0]); };
  expect_all(of(square([](const Vec3f& p) { return Vec2f(p.x, p.y); })), {1, 0, 0, 1});
  expect_all(of(square([](const Vec3f& p) { return Vec2f(-p.x, p.y); })), {-1, 0, 0, -1});
  expect_all(of(square([](const Vec3f& p) { return Vec2f(3 * p.y, -2 * p.x); })), {0, 1, 0, 1});
  expect_all(of(square([](const Vec3f&) { return Vec2f(0.5f, 0.5f); })), {0, 0, 0, 1});
}

// u turns by 90 degrees between two triangles that share an edge; equal uvs on the edge make its corners share the mean
// of the two directions, weighted by the angle of either triangle there.
TEST(Tangents, AreTheMeanWeightedByAngle) {
  Mesh mesh;
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.normals.assign(4, Vec3f(0, 0, 1));
  MeshAttribute<Vec2f> uvs;
  uvs.values = {{0, 0}, {1, 0}, {0, 1}, {-1, 1}};  // second triangle: u along -(x + ...)
  const auto tangents = compute_tangents(mesh, uvs);
  // Triangle 0: u = x, v = y. Triangle 1 has edges y -> (0, 1) and -x -> (-1, 1): u = x, v = y - x.
  const auto& c = tangents.triangles;
  EXPECT_EQ(c[0][0], c[1][0]);
  EXPECT_EQ(c[0][2], c[1][1]);
  // At the shared corners: 90 degrees of triangle 0 and of triangle 1 (both right angles at 0), 45 and 45 at point 2.
  // dp/du of triangle 1 with dp = e1 a + e2 b, du = 0 a - b, dv = a + b: dp/du = e1 - e2 = (1, 1, 0).
  const Vec3f along = normalize(normalize(Vec3f(1, 0, 0)) + normalize(Vec3f(1, 1, 0)));
  for (const uint32_t i : {c[0][0], c[0][2]}) {
    EXPECT_NEAR(tangents.values[i].x, along.x, 1e-6f);
    EXPECT_NEAR(tangents.values[i].y, along.y, 1e-6f);
  }
  EXPECT_NEAR(tangents.values[c[0][1]].x, 1, 1e-6f) << "triangle 0 alone";
}

TEST(Tangents, ArePerpendicularToTheNormalsOfTheCorner) {
  Mesh mesh = square([](const Vec3f& p) { return Vec2f(p.x, p.y); });
  const Vec3f n = normalize(Vec3f(0.3f, -0.2f, 1));
  mesh.normals.assign(4, n);
  const auto tangents = compute_tangents(mesh, mesh.uv_sets[0]);
  const Vec3f expected = normalize(Vec3f(1, 0, 0) - n * n.x);
  expect_all(tangents, {expected.x, expected.y, expected.z, 1});
}

TEST(TangentCache, GivesAuthoredOnesFirstAndNoneWithoutTheUvSet) {
  Mesh mesh = square([](const Vec3f& p) { return Vec2f(p.x, p.y); });
  const TangentCache cache;
  EXPECT_EQ(cache.of(mesh, "st1"), nullptr);
  auto computed = cache.of(mesh, "st");
  ASSERT_NE(computed, nullptr);
  EXPECT_EQ(cache.of(mesh, "st"), computed) << "once";
  EXPECT_GT(cache.memory_bytes(), 0u);
  mesh.tangents.values.assign(4, Vec4f(0, 1, 0, 1));
  EXPECT_EQ(cache.of(mesh, "st").get(), &mesh.tangents);
}

// glTF-Sample-Viewer 592: an image that is turned on the surface takes the directions of its normals with it.
TEST(TangentCache, FollowsTheCoordinatesOfTheImage) {
  const Mesh mesh = square([](const Vec3f& p) { return Vec2f(p.x, p.y); });
  const TangentCache cache;
  const auto plain = cache.of(mesh, "st");
  EXPECT_EQ(cache.of(mesh, "st", {Vec2f(3, 0), Vec2f(0, 0.5f)}), plain) << "scales leave the directions";
  EXPECT_EQ(cache.of(mesh, "st", {Vec2f(0, 0), Vec2f(0, 0)}), plain) << "an image of one colour has none";
  const TangentCache::Axes turned = {Vec2f(0, 3), Vec2f(-2, 0)};
  auto across = cache.of(mesh, "st", turned);
  expect_all(*across, {0, 1, 0, 1});
  EXPECT_EQ(cache.of(mesh, "st", turned), across) << "once";
  expect_all(*cache.of(mesh, "st", {Vec2f(-1, 0), Vec2f(0, 1)}), {-1, 0, 0, -1});
  const size_t both = cache.memory_bytes();
  across = nullptr;
  EXPECT_LT(cache.memory_bytes(), both) << "kept while held: a transform that an edit changes leaves nothing behind";
  expect_all(*cache.of(mesh, "st"), {1, 0, 0, 1});
}

TEST(TangentCache, CountsWhatItHoldsAndIsAskedAgainWhereMemoryRefusedIt) {
  const Mesh mesh = square([](const Vec3f& p) { return Vec2f(p.x, p.y); });
  const auto budget = std::make_shared<MemoryBudget>(100);
  {
    TangentCache cache;
    cache.count_in(budget);
    EXPECT_THROW(cache.of(mesh, "st"), MemoryRefused);
    EXPECT_EQ(budget->in_use(), 0u);
    EXPECT_THROW(cache.of(mesh, "st"), MemoryRefused) << "and no empty ones";
    budget->set_limit(10000);
    const auto held = cache.of(mesh, "st");
    ASSERT_NE(held, nullptr);
    EXPECT_GT(cache.memory_bytes(), 0u);
    EXPECT_EQ(budget->in_use(), cache.memory_bytes());
  }
  EXPECT_EQ(budget->in_use(), 0u);
}

}  // namespace
}  // namespace alabaster
