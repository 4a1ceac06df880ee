#include "core/subsurface/shells.h"

#include <gtest/gtest.h>

#include "testenv/support/cages.h"

namespace alabaster {
namespace {

// The cube of cages.h moved and scaled; `turned`: wound the other way.
Cage box(const Vec3f& centre, float half, bool turned = false) {
  Cage cage = test::cube_cage();
  for (Vec3f& p : cage.points) p = p * half + centre;
  if (turned) std::reverse(cage.face_vertex_indices.begin(), cage.face_vertex_indices.end());
  return cage;
}

Cage both(Cage a, const Cage& b) {
  const int first = static_cast<int>(a.points.size());
  a.points.insert(a.points.end(), b.points.begin(), b.points.end());
  for (int i : b.face_vertex_indices) a.face_vertex_indices.push_back(i + first);
  a.face_vertex_counts.insert(a.face_vertex_counts.end(), b.face_vertex_counts.begin(), b.face_vertex_counts.end());
  return a;
}

struct Found {
  Mesh mesh;
  MeshShells shells;
  std::shared_ptr<const ObjectScene> object;

  /// Triangles that have all of the flags.
  size_t count(uint8_t flags) const {
    size_t n = 0;
    for (uint32_t t = 0; t < mesh.triangles.size(); ++t) n += (shells.flags(t) & flags) == flags ? 1 : 0;
    return n;
  }
  int winding(const Vec3f& p, const Vec3f& direction = {0.3f, 0.2f, 0.9f}) const {
    return winding_number(mesh, shells, *object, {p, direction});
  }
};

Found find(const Cage& cage) {
  static const auto device = make_trace_device({});
  Found found;
  found.mesh = build_mesh(cage, {}, {});
  found.object = build_object_scene(device, found.mesh, {});
  found.shells = find_shells(found.mesh, *found.object);
  return found;
}

TEST(Shells, SoundMeshHasNoWarnings) {
  for (const Cage& cage : {box({5, 0, 0}, 1), test::octahedron_cage(), test::pentagon_prism_cage()}) {
    const Found f = find(cage);
    EXPECT_TRUE(f.shells.triangle_flags.empty());
    EXPECT_FALSE(f.shells.overlapping);
    EXPECT_FALSE(f.shells.any_open);
  }
}

TEST(Shells, SplitPointsAreWelded) {
  Cage split = box({0, 0, 0}, 1);
  std::vector<Vec3f> points;
  for (int& i : split.face_vertex_indices) {
    points.push_back(split.points[static_cast<size_t>(i)]);
    i = static_cast<int>(points.size()) - 1;
  }
  split.points = points;
  EXPECT_TRUE(find(split).shells.triangle_flags.empty());
}

TEST(Shells, HolesMakeAShellOpenAndLeaveTheOthersClosed) {
  Cage cage = both(box({0, 0, 0}, 1), box({5, 0, 0}, 1));
  cage.hole_indices = {2};
  const Found f = find(cage);
  EXPECT_TRUE(f.shells.any_open);
  EXPECT_EQ(f.count(MeshShells::kOpen), 10u);
  EXPECT_EQ(f.winding({0.1f, 0.2f, 0}), 0) << "an open shell contains nothing";
  EXPECT_EQ(f.winding({5.1f, 0.2f, 0}), 1);
}

TEST(Shells, AShellWithinThatWindsTheOtherWayIsACavity) {
  for (const bool inverted : {false, true}) {
    const Found hollow = find(both(box({0, 0, 0}, 2, inverted), box({0, 0, 0}, 1, !inverted)));
    EXPECT_EQ(hollow.winding({0.1f, 0.2f, 0}), 0);
    EXPECT_EQ(hollow.winding({1.5f, 0.2f, 0}), 1);
    EXPECT_FALSE(hollow.shells.overlapping);
    const Found solid = find(both(box({0, 0, 0}, 2, inverted), box({0, 0, 0}, 1, inverted)));
    EXPECT_EQ(solid.winding({0.1f, 0.2f, 0}), 2);
    EXPECT_TRUE(solid.shells.overlapping);
  }
  // Beside each other, one of them inside out: both are solid.
  const Found pair = find(both(box({0, 0, 0}, 2), box({6, 0, 0}, 1, true)));
  EXPECT_EQ(pair.winding({6.1f, 0.2f, 0}), 1);
  EXPECT_EQ(pair.count(MeshShells::kReversed), 12u);
}

TEST(Shells, OverlapsAreFound) {
  EXPECT_TRUE(find(both(box({0, 0, 0}, 1), box({1.5f, 0.1f, 0.2f}, 1))).shells.overlapping);
  EXPECT_TRUE(find(both(box({0, 0, 0}, 1), box({1.99f, 1.9f, 0.2f}, 1, true))).shells.overlapping);
  EXPECT_FALSE(find(both(box({0, 0, 0}, 1), box({2.01f, 0.1f, 0.2f}, 1))).shells.overlapping);
  // One pair of many overlaps, at a corner.
  Cage many = box({0, 0, 0}, 1);
  for (int i = 1; i < 1000; ++i) many = both(many, box({0, 0, 3.0f * static_cast<float>(i)}, 1));
  EXPECT_FALSE(find(many).shells.overlapping);
  EXPECT_TRUE(find(both(many, box({1.99f, 1.99f, 1.99f}, 1))).shells.overlapping);
  // A bar that folds back through itself: one shell, wound twice around where it does.
  Cage bar = box({0, 0, 0}, 1);
  for (size_t i = 0; i < 8; ++i)
    if (bar.points[i].x > 0 && bar.points[i].y > 0) bar.points[i] = Vec3f(-3, -3, bar.points[i].z);
  EXPECT_EQ(find(bar).shells.any_open, false);
}

TEST(Shells, CoincidentTrianglesAreOne) {
  const Found twice = find(both(box({0, 0, 0}, 1), box({0, 0, 0}, 1)));
  EXPECT_TRUE(twice.shells.triangle_flags.empty());
  EXPECT_FALSE(twice.shells.overlapping);
  EXPECT_EQ(twice.winding({0.1f, 0.2f, 0}), 1);
  const Found thrice = find(both(both(box({0, 0, 0}, 1), box({0, 0, 0}, 1, true)), box({0, 0, 0}, 1)));
  EXPECT_EQ(thrice.count(MeshShells::kReversed), 12u);
  EXPECT_EQ(thrice.winding({0.1f, 0.2f, 0}), 1);
}

// Triangles whose copies turn about the first corner, so that both lie on each other.
Cage doubled_triangles(const Cage& quads, bool by_face) {
  Cage cage = quads;
  cage.face_vertex_counts.assign(4 * quads.face_vertex_counts.size(), 3);
  cage.face_vertex_indices.clear();
  std::vector<int> turned;
  for (size_t i = 0; i < quads.face_vertex_indices.size(); i += 4)
    for (const size_t last : {2u, 3u}) {
      const int* const q = &quads.face_vertex_indices[i];
      for (const int v : {q[0], q[last - 1], q[last]}) cage.face_vertex_indices.push_back(v);
      auto& copies = by_face ? cage.face_vertex_indices : turned;
      for (const int v : {q[0], q[last], q[last - 1]}) copies.push_back(v);
    }
  cage.face_vertex_indices.insert(cage.face_vertex_indices.end(), turned.begin(), turned.end());
  return cage;
}

// Modellers double the faces of what is to be seen from both sides, at once or face by face.
TEST(Shells, ABodyOfDoubledFacesIsClosed) {
  const Cage all = doubled_triangles(box({0, 0, 0}, 1), false);
  for (const Cage& cage : {all, doubled_triangles(box({0, 0, 0}, 1), true), both(all, box({5, 0, 0}, 1))}) {
    const Found f = find(cage);
    EXPECT_EQ(f.count(MeshShells::kReversed), 12u);
    EXPECT_EQ(f.count(MeshShells::kOpen), 0u);
    EXPECT_FALSE(f.shells.any_open);
    EXPECT_FALSE(f.shells.overlapping);
    EXPECT_EQ(f.winding({0.1f, 0.2f, 0}), 1);
    EXPECT_EQ(f.winding({0.1f, 2, 0}), 0);
  }
  Cage holed = doubled_triangles(box({0, 0, 0}, 1), true);  // without a triangle and its copy
  holed.face_vertex_counts.resize(22), holed.face_vertex_indices.resize(66);
  EXPECT_EQ(find(holed).count(MeshShells::kOpen), 22u);
}

TEST(Shells, ATwoSidedSheetHasNoInside) {
  Cage sheet = test::grid_cage(3), back = sheet;
  std::reverse(back.face_vertex_indices.begin(), back.face_vertex_indices.end());
  // Split each face alike, so that the triangles lie on each other.
  const auto triangles = [](const Cage& cage) {
    Cage t = cage;
    t.face_vertex_counts.clear(), t.face_vertex_indices.clear();
    for (size_t i = 0; i < cage.face_vertex_indices.size(); i += 4) {
      std::array<int, 4> q;
      std::copy_n(cage.face_vertex_indices.begin() + static_cast<long>(i), 4, q.begin());
      std::rotate(q.begin(), std::min_element(q.begin(), q.end()), q.end());
      for (int v : {q[0], q[1], q[2], q[0], q[2], q[3]}) t.face_vertex_indices.push_back(v);
      t.face_vertex_counts.insert(t.face_vertex_counts.end(), {3, 3});
    }
    return t;
  };
  const Found f = find(both(triangles(sheet), triangles(back)));
  EXPECT_FALSE(f.mesh.closed) << "without its doubled faces the sheet has an outline";
  EXPECT_EQ(f.count(MeshShells::kOpen), f.mesh.triangles.size());
}

TEST(Shells, OneSidedSurfacesAreOpen) {
  Cage strip;  // a Moebius strip, closed by a disc: no edge is open, yet there is no inside
  constexpr int kSteps = 16;
  for (int i = 0; i < kSteps; ++i) {
    const float a = kTwoPi * static_cast<float>(i) / kSteps;
    for (const float w : {-0.3f, 0.3f})
      strip.points.emplace_back((1 + w * std::cos(a / 2)) * std::cos(a), (1 + w * std::cos(a / 2)) * std::sin(a),
                                w * std::sin(a / 2));
  }
  strip.points.emplace_back(0.0f, 0.0f, 3.0f);
  const auto at = [](int i, int side) { return 2 * (i % kSteps) + (i < kSteps ? side : 1 - side); };
  for (int i = 0; i < kSteps; ++i) {
    strip.face_vertex_counts.push_back(4);
    for (int v : {at(i, 0), at(i, 1), at(i + 1, 1), at(i + 1, 0)}) strip.face_vertex_indices.push_back(v);
  }
  for (int i = 0; i < 2 * kSteps; ++i) {
    const auto rim = [&](int k) { return 2 * (k % kSteps) + (k / kSteps) % 2; };
    strip.face_vertex_counts.push_back(3);
    for (int v : {rim(i), rim(i + 1), 2 * kSteps}) strip.face_vertex_indices.push_back(v);
  }
  const Found f = find(strip);
  EXPECT_TRUE(f.mesh.closed);
  EXPECT_TRUE(f.shells.any_open);
}

TEST(Shells, ScaleChangesNothing) {
  for (const int k : {-40, 40}) {
    SCOPED_TRACE(k);
    const float s = std::ldexp(1.0f, k);
    const Found f = find(both(box({0, 0, 0}, 2 * s), box({0, 0, 0}, s, true)));
    EXPECT_TRUE(f.shells.triangle_flags.empty());
    EXPECT_FALSE(f.shells.overlapping);
    EXPECT_TRUE(find(both(box({0, 0, 0}, s), box({1.5f * s, 0, 0}, s))).shells.overlapping);
  }
}

TEST(Shells, CachedTopologyGivesTheShellsOfEditedPoints) {
  ShellTopologyCache cache(nullptr);
  Cage cage = both(box({0, 0, 0}, 1), box({5, 0, 0}, 1, true));
  const auto device = make_trace_device({});
  // Moved, then one into the other, then with a point on another one, then torn apart again.
  const std::vector<std::pair<size_t, Vec3f>> edits{{0, {-1.2f, -1, -1}}, {7, {5, 0.5f, 0.5f}}, {1, {-1.2f, -1, -1}},
                                                    {1, {1, -1, -1}},     {7, {1, 1, 1}},       {9, {6, 0, 0}}};
  for (const auto& [point, to] : edits) {
    cage.points[point] = to;
    const Mesh mesh = build_mesh(cage, {}, {});
    const auto object = build_object_scene(device, mesh, {});
    const MeshShells cached = find_shells(mesh, *object, {}, &cache), fresh = find_shells(mesh, *object);
    EXPECT_EQ(cached.triangle_flags, fresh.triangle_flags);
    EXPECT_EQ(cached.any_open, fresh.any_open);
    EXPECT_EQ(cached.any_closed, fresh.any_closed);
    EXPECT_EQ(cached.overlapping, fresh.overlapping);
  }
}

TEST(Shells, TopologyIsFoundOnceAndCounted) {
  const auto budget = std::make_shared<MemoryBudget>();
  ShellTopologyCache cache(budget);
  const std::vector<WeldedCorners> one{{0, 1, 2}, {0, 2, 1}}, other{{0, 1, 2}, {0, 1, 2}};
  const auto first = cache.get(one, 3, {});
  EXPECT_EQ(cache.get(one, 3, {}), first);
  EXPECT_GT(budget->in_use(MemoryUse::subsurface), 0u);
  EXPECT_NE(cache.get(other, 3, {}), first);
  cache.forget();
  EXPECT_EQ(budget->in_use(MemoryUse::subsurface), 0u);
  budget->set_limit(1);
  EXPECT_TRUE(cache.get(one, 3, {})) << "without memory to keep it";
  EXPECT_EQ(budget->in_use(MemoryUse::subsurface), 0u);
}

TEST(Shells, MalformedMeshesAreAccepted) {
  EXPECT_TRUE(find(Cage()).shells.triangle_flags.empty());
  Cage flat = test::cube_cage();
  for (Vec3f& p : flat.points) p = Vec3f(1, 1, 1);
  EXPECT_FALSE(find(flat).shells.overlapping);
}

}  // namespace
}  // namespace alabaster
