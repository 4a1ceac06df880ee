#include "core/geometry/edited_object.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "core/geometry/hierarchy_cost.h"
#include "core/geometry/triangle_pairs.h"
#include "testenv/support/cages.h"
#include "testenv/support/scene_builder.h"

namespace alabaster {
namespace {

// A sphere whose points are pushed about by up to `by`, or turned about z by so much for each unit of z.
Mesh moved(float by, float twist = 0) {
  Mesh mesh = testing::sphere_mesh(1, 48, true);
  mesh.bounds = {};
  for (Vec3f& p : mesh.points) {
    p.x += by * std::sin(7 * p.y);
    const float c = std::cos(twist * p.z), s = std::sin(twist * p.z);
    p = {p.x * c - p.y * s, p.x * s + p.y * c, p.z};
    mesh.bounds.extend(p);
  }
  return mesh;
}

class EditedObjects : public ::testing::Test {
 protected:
  // The first hits of rays from without and within.
  static std::vector<TriangleHit> hits(const ObjectScene& object) {
    std::vector<TriangleHit> all;
    for (int i = 0; i < 5000; ++i) {
      const auto share = [i](double step) { return static_cast<float>(std::fmod(0.5 + i * step, 1.0)) * 2 - 1; };
      const Vec3f to(share(0.8191725134), share(0.6710436067), share(0.5497004779));
      TriangleHit hit;
      if (object.intersect({i % 2 ? to * 3.0f : to * 0.2f, i % 2 ? -to : to}, &hit)) all.push_back(hit);
    }
    return all;
  }
  static void expect_same(const std::vector<TriangleHit>& a, const std::vector<TriangleHit>& b) {
    ASSERT_EQ(a.size(), b.size());
    EXPECT_GT(a.size(), 4000u);
    for (size_t i = 0; i < a.size(); ++i)
      EXPECT_TRUE(a[i].triangle == b[i].triangle && a[i].t == b[i].t && a[i].u == b[i].u && a[i].v == b[i].v) << i;
  }
  size_t traced_bytes() const { return memory_->in_use(MemoryUse::tracing); }

  std::shared_ptr<MemoryBudget> memory_ = std::make_shared<MemoryBudget>();
  test::RecordingSink sink_;
  std::shared_ptr<TraceDevice> device_ = make_trace_device(sink_.sink(), memory_);
  EditedObject edited_;
};

TEST_F(EditedObjects, ReusedObjectHasTheHitsOfANewOne) {
  std::shared_ptr<const ObjectScene> shown, next;
  std::vector<const ObjectScene*> seen;
  for (int edit = 0; edit < 6; ++edit) {
    const Mesh mesh = moved(0.004f * static_cast<float>(edit));
    const Mesh before = moved(0.004f * static_cast<float>(edit - 1));
    next = edited_.build(device_, mesh);
    ASSERT_TRUE(next);
    expect_same(hits(*next), hits(*build_object_scene(device_, mesh, {})));
    if (shown) expect_same(hits(*shown), hits(*build_object_scene(device_, before, {})));
    seen.push_back(next.get());
    shown = std::move(next);
  }
  for (size_t i = 2; i < seen.size(); ++i) EXPECT_EQ(seen[i], seen[i - 2]) << "two take turns";
  EXPECT_NE(seen[0], seen[1]);
}

// Embree has this one as quads.
TEST_F(EditedObjects, ReusedObjectOfQuadsHasTheHitsOfANewOne) {
  const auto edited = [](float by) {
    RefinementOptions options;
    options.level = 4;
    Cage cage = test::cube_cage(SubdivisionScheme::catmull_clark);
    for (Vec3f& p : cage.points) p = p * (1.5f + by * p.y);
    return build_mesh(cage, options, {});
  };
  const Mesh first = edited(0), second = edited(0.01f);
  ASSERT_TRUE(are_pairs(first.triangles));
  const void* const place = edited_.build(device_, first, {}).get();
  const auto refitted = edited_.build(device_, second, {});
  EXPECT_EQ(refitted.get(), place) << "has the place of the first";
  expect_same(hits(*refitted), hits(*build_object_scene(device_, second, {})));
  Mesh turned = first;
  for (Corners& c : turned.triangles) turn(&c, 1);
  expect_same(hits(*edited_.build(device_, turned, {})), hits(*build_object_scene(device_, turned, {})));
}

TEST_F(EditedObjects, ChangedTrianglesAreBuiltAnew) {
  const Mesh cube = build_mesh(test::cube_cage(), {}, {});
  for (const Mesh& mesh : {moved(0), cube, moved(0.01f)}) {
    const auto object = edited_.build(device_, mesh);
    TriangleHit hit, fresh;
    ASSERT_TRUE(object->intersect({{3, 0.1f, 0.2f}, {-1, 0, 0}}, &hit));
    ASSERT_TRUE(build_object_scene(device_, mesh, {})->intersect({{3, 0.1f, 0.2f}, {-1, 0, 0}}, &fresh));
    EXPECT_EQ(hit.t, fresh.t);
    EXPECT_EQ(hit.triangle, fresh.triangle);
  }
}

TEST_F(EditedObjects, CancelledOrRefusedBuildsLeaveNoMemory) {
  std::atomic<bool> cancelled{true};
  EXPECT_THROW(edited_.build(device_, moved(0), CancelToken(&cancelled)), BuildCancelled);
  EXPECT_TRUE(edited_.build(device_, moved(0)));  // and is a spare
  EXPECT_THROW(edited_.build(device_, moved(0.01f), CancelToken(&cancelled)), BuildCancelled);
  const Mesh mesh = moved(0.02f);
  expect_same(hits(*edited_.build(device_, mesh)), hits(*build_object_scene(device_, mesh, {})));
  EXPECT_TRUE(sink_.all().empty());
}

TEST_F(EditedObjects, MemoryIsCountedAndSparesAreFreed) {
  const size_t before = traced_bytes();
  auto shown = edited_.build(device_, moved(0));
  const size_t one = traced_bytes() - before;
  EXPECT_GT(one, 0u);
  edited_.build(device_, moved(0.01f));
  EXPECT_GT(traced_bytes() - before, one * 3 / 2) << "the spare counts";
  edited_.rest();
  EXPECT_LE(traced_bytes() - before, one * 5 / 4);
  shown = nullptr;
  EXPECT_LE(traced_bytes(), before + one / 4) << "no spare while it rests";
}

TEST_F(EditedObjects, ObjectsOutliveTheirEditor) {
  std::shared_ptr<const ObjectScene> object;
  {
    EditedObject edited;
    object = edited.build(device_, moved(0));
  }
  expect_same(hits(*object), hits(*build_object_scene(device_, moved(0), {})));
}

TEST(TriangleGroups, CostMoreTheFartherTheirTrianglesAreApart) {
  const Mesh rest = moved(0);
  const TriangleGroups groups(rest);
  const double built = groups.cost(rest);
  Mesh shifted = rest;
  for (Vec3f& p : shifted.points) p = p * 4.0f + Vec3f(64, 0, 0);
  EXPECT_NEAR(groups.cost(shifted), built, 1e-3 * built);
  EXPECT_LT(groups.cost(moved(0.02f)), 1.1 * built);
  double last = built;
  for (const float twist : {0.5f, 1.0f, 2.0f}) {
    const double cost = groups.cost(moved(0, twist));
    EXPECT_GT(cost, last);
    last = cost;
  }
  EXPECT_GT(last, 1.1 * built);
}

}  // namespace
}  // namespace alabaster
