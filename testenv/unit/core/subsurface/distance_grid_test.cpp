#include "core/subsurface/distance_grid.h"

#include <gtest/gtest.h>

#include "core/math/frame.h"
#include "core/sampling/pixel_sampler.h"
#include "core/sampling/warp.h"
#include "testenv/support/scene_builder.h"

namespace alabaster {
namespace {

// Ericson 2005, "Real-Time Collision Detection", section 5.1.5.
Vec3d closest_on_triangle(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const Vec3d ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const double d1 = dot(ab, ap), d2 = dot(ac, ap), d3 = dot(ab, bp), d4 = dot(ac, bp), d5 = dot(ab, cp),
               d6 = dot(ac, cp);
  if (d1 <= 0 && d2 <= 0) return a;
  if (d3 >= 0 && d4 <= d3) return b;
  if (d6 >= 0 && d5 <= d6) return c;
  const double va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + ab * (d1 / (d1 - d3));
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + ac * (d2 / (d2 - d6));
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
  return a + ab * (vb / (va + vb + vc)) + ac * (vc / (va + vb + vc));
}

double true_distance(const Mesh& mesh, const Vec3f& point) {
  const Vec3d p(point.x, point.y, point.z);
  double nearest = std::numeric_limits<double>::infinity();
  const auto corner = [&](uint32_t i) { return Vec3d(mesh.points[i].x, mesh.points[i].y, mesh.points[i].z); };
  for (const auto& t : mesh.triangles)
    nearest = std::min(nearest, length(p - closest_on_triangle(p, corner(t[0]), corner(t[1]), corner(t[2]))));
  return nearest;
}

Mesh mesh_of(std::vector<Vec3f> points, std::vector<std::array<uint32_t, 3>> triangles) {
  Mesh mesh;
  mesh.points = std::move(points);
  mesh.triangles = std::move(triangles);
  for (const Vec3f& p : mesh.points) mesh.bounds.extend(p);
  return mesh;
}

// Twelve triangles, each far larger than a voxel.
Mesh box_mesh(const Vec3f& half, const Vec3f& centre) {
  const auto points = Bounds{centre - half, centre + half}.corners();
  return mesh_of({points.begin(), points.end()}, {{0, 2, 1},
                                                  {1, 2, 3},
                                                  {4, 5, 6},
                                                  {5, 7, 6},
                                                  {0, 1, 4},
                                                  {1, 5, 4},
                                                  {2, 6, 3},
                                                  {3, 6, 7},
                                                  {0, 4, 2},
                                                  {2, 4, 6},
                                                  {1, 3, 5},
                                                  {3, 7, 5}});
}

// Triangles of all sizes and directions: slivers, points, sheets through everything.
Mesh random_mesh(int count, uint64_t seed) {
  Rng rng(seed, 9);
  std::vector<Vec3f> points;
  std::vector<std::array<uint32_t, 3>> triangles;
  for (int i = 0; i < count; ++i) {
    const auto point = [&](float size) {
      return Vec3f(rng.uniform() - 0.5f, rng.uniform() - 0.5f, rng.uniform() - 0.5f) * size;
    };
    const Vec3f base = point(2);
    const auto first = static_cast<uint32_t>(points.size());
    const float size = std::ldexp(1.0f, -static_cast<int>(rng.uniform() * 12));
    points.insert(points.end(), {base, base + point(size), base + point(size * rng.uniform())});
    triangles.push_back({first, first + 1, first + 2});
  }
  return mesh_of(points, triangles);
}

struct Case {
  const char* name;
  Mesh mesh;
  uint32_t resolution;

  float voxel() const { return max_component(mesh.bounds.extent()) / static_cast<float>(resolution); }
};

std::vector<Case> cases() {
  std::vector<Case> all;
  all.push_back({"sphere", testing::sphere_mesh(1, 48, false), 64});
  all.push_back({"box", box_mesh({1, 0.3f, 0.7f}, {0, 0, 0}), 48});
  all.push_back({"far box", box_mesh({1, 1, 1}, {3e5f, -2e5f, 1e5f}), 32});
  all.push_back({"plane", testing::plane_mesh(3), 40});
  all.push_back({"soup", random_mesh(40, 1), 64});
  all.push_back({"small soup", random_mesh(12, 2), 255});
  all.push_back({"one voxel", box_mesh({1, 1, 1}, {0, 0, 0}), 1});
  return all;
}

TEST(DistanceGrid, NeverExceedsTheTrueDistance) {
  for (const Case& c : cases()) {
    const auto grid = build_distance_grid(c.mesh, c.resolution);
    ASSERT_TRUE(grid) << c.name;
    Rng rng(7, 9);
    const Vec3f extent = c.mesh.bounds.extent() * 1.1f + Vec3f(c.voxel() * 0.1f);
    int positive = 0;
    for (int i = 0; i < 3000; ++i) {
      const Vec3f p =
          c.mesh.bounds.center() + Vec3f((rng.uniform() - 0.5f) * extent.x, (rng.uniform() - 0.5f) * extent.y,
                                         (rng.uniform() - 0.5f) * extent.z);
      const double bound = grid->bound(p), distance = true_distance(c.mesh, p);
      ASSERT_LE(bound, distance * (1 + 1e-7)) << c.name << " at " << p.x << " " << p.y << " " << p.z;
      positive += bound > 0;
    }
    EXPECT_TRUE(positive > 100 || c.resolution <= 40) << c.name;
  }
}

TEST(DistanceGrid, MissesByFourVoxelsAtMost) {
  for (const Case& c : cases()) {
    const auto grid = build_distance_grid(c.mesh, c.resolution);
    Rng rng(8, 9);
    const double furthest_stored = 255 / 4.0 * c.voxel();
    double missed = 0;
    constexpr int kPoints = 1000;
    for (int i = 0; i < kPoints; ++i) {
      const Vec3f& lower = c.mesh.bounds.lower;
      const Vec3f extent = c.mesh.bounds.extent();
      const Vec3f p = lower + Vec3f(rng.uniform() * extent.x, rng.uniform() * extent.y, rng.uniform() * extent.z);
      const double short_by = std::min(true_distance(c.mesh, p), furthest_stored) - grid->bound(p);
      ASSERT_LE(short_by, 4 * c.voxel()) << c.name;
      missed += short_by / kPoints;
    }
    EXPECT_LT(missed, 2 * c.voxel()) << c.name;
  }
}

TEST(DistanceGrid, IsZeroWhereNothingIsKnown) {
  const auto grid = build_distance_grid(box_mesh({1, 1, 1}, {0, 0, 0}), 32);
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN(), kInfinity = std::numeric_limits<float>::infinity();
  for (const Vec3f& p :
       {Vec3f(5, 0, 0), Vec3f(0, -1.01f, 0), Vec3f(kNan, 0, 0), Vec3f(0, kInfinity, 0), Vec3f(-1, 1, 1)})
    EXPECT_EQ(grid->bound(p), 0);
  EXPECT_GT(grid->bound({0, 0, 0}), 0.83f);
}

TEST(DistanceGrid, RefusesWhatHasNoExtentOrNoEnd) {
  EXPECT_FALSE(build_distance_grid(Mesh(), 32));
  EXPECT_FALSE(build_distance_grid(mesh_of({{1, 1, 1}}, {{0, 0, 0}}), 32));
  EXPECT_FALSE(build_distance_grid(mesh_of({{0, 0, 0}, {1e-45f, 0, 0}}, {{0, 0, 1}}), 32));
  // Two thousand sheets through the whole of it.
  std::vector<std::array<uint32_t, 3>> sheets(2000, {0, 1, 2});
  EXPECT_FALSE(build_distance_grid(mesh_of({{0, 0, 0}, {1, 1, 0}, {0, 1, 1}}, sheets), 128));
}

}  // namespace
}  // namespace alabaster
