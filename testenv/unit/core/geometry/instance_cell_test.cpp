#include "core/geometry/instance_cell.h"

#include <gtest/gtest.h>

#include <random>

#include "core/geometry/embree_scene.h"
#include "testenv/support/cages.h"

namespace alabaster {
namespace {

constexpr uint32_t kCount = 2500;  // three cells

// A cube of side 2 in every place, turned, stretched and, now and then, mirrored.
std::vector<Placement> random_placements() {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> number(-1, 1);
  std::vector<Placement> all;
  for (uint32_t i = 0; i < kCount; ++i) {
    Matrix4d m = Matrix4d().rotate(Vec3d(number(random), number(random), number(random)) * 3);
    m = Matrix4d().setScale(Vec3d(0.02 + 0.01 * number(random), 0.03, i % 7 ? 0.02 : -0.04)) * m;
    for (int axis = 0; axis < 3; ++axis) m[3][axis] = number(random);
    all.push_back({to_affine(m), to_affine(m.inverse())});
  }
  return all;
}

class InstanceCellTest : public ::testing::Test {
 protected:
  InstanceCells cells(const std::vector<Placement>& placements) {
    std::vector<CellInstances> parts(3);
    std::vector<std::vector<uint32_t>> numbers(3);
    std::vector<uint32_t> slots;
    for (uint32_t i = 0; i < placements.size(); ++i) {
      const uint32_t cell = i / InstanceCells::kMost;
      slots.push_back(cell * InstanceCells::kMost + static_cast<uint32_t>(numbers[cell].size()));
      numbers[cell].push_back(i);
      parts[cell].placements.push_back(placements[i]);
      parts[cell].hidden.push_back(false);
    }
    InstanceCells array;
    array.slots = std::make_shared<const std::vector<uint32_t>>(std::move(slots));
    for (size_t i = 0; i < parts.size(); ++i) {
      parts[i].numbers = std::make_shared<const std::vector<uint32_t>>(numbers[i]);
      array.cells.push_back(build_instance_cell(device_, cube_, std::move(parts[i])));
    }
    return array;
  }
  std::vector<Ray> rays(int count) {
    std::mt19937 random(3);
    std::uniform_real_distribution<float> number(-1, 1);
    std::vector<Ray> all;
    for (int i = 0; i < count; ++i)
      all.push_back({{2 * number(random), 2 * number(random), 3}, {number(random) * 0.3f, number(random) * 0.3f, -1}});
    return all;
  }

  std::shared_ptr<TraceDevice> device_ = make_trace_device({});
  std::shared_ptr<const ObjectScene> cube_ = build_object_scene(device_, build_mesh(test::cube_cage(), {}, {}), {});
};

// The oracle is Embree's own instancing.
TEST_F(InstanceCellTest, RaysMeetTheSameAsAmongInstancesThatStandAlone) {
  const std::vector<Placement> placements = random_placements();
  std::vector<InstancePlacement> alone;
  for (const Placement& p : placements) alone.push_back({cube_, p.object_to_world});
  const auto expected = build_instanced_scene(device_, alone);
  const auto scene = build_instanced_scene(device_, {}, {}, {cells(placements)});
  ASSERT_TRUE(expected && scene);
  int met = 0;
  for (const Ray& ray : rays(20000)) {
    TriangleHit a, b;
    const bool hit = expected->intersect(ray, &a);
    ASSERT_EQ(scene->intersect(ray, &b), hit);
    EXPECT_EQ(scene->occluded(ray), hit);
    if (!hit) continue;
    ++met;
    ASSERT_EQ(b.instance, a.instance);
    ASSERT_EQ(b.triangle, a.triangle);
    EXPECT_NEAR(b.t, a.t, 1e-5f * a.t);
    EXPECT_NEAR(b.u, a.u, 1e-3f);
    Ray shorter = ray;
    shorter.tmax = b.t * 0.999f;
    TriangleHit nearer;
    if (scene->intersect(shorter, &nearer)) {
      EXPECT_LT(nearer.t, b.t);
    }
  }
  EXPECT_GT(met, 4000);
}

// Embree answers any hit of so small a triangle with its first corner.
TEST_F(InstanceCellTest, HitsOfTheSmallestTrianglesHaveTheirBarycentrics) {
  const float s = 0x1p-36f;
  Mesh mesh;
  mesh.points = {Vec3f(0, 0, 2) * s, Vec3f(4, 0, 2) * s, Vec3f(0, 4, 2) * s};
  mesh.triangles = {{0, 1, 2}};
  CellInstances one{std::make_shared<const std::vector<uint32_t>>(1, 0),
                    {{{{0, 2, 0}, {-2, 0, 0}, {0, 0, 2}, {0, 0, 0}}, {{0, -0.5f, 0}, {0.5f, 0, 0}, {0, 0, 0.5f}}}},
                    {false}};
  InstanceCells array;
  array.slots = std::make_shared<const std::vector<uint32_t>>(std::vector<uint32_t>{0});
  array.cells = {build_instance_cell(device_, build_object_scene(device_, mesh, {}), std::move(one))};
  const auto scene = build_instanced_scene(device_, {}, {}, {array});
  TriangleHit hit;
  ASSERT_TRUE(scene->intersect({Vec3f(-4, 2, 10) * s, {0, 0, -1}}, &hit));
  EXPECT_FLOAT_EQ(hit.u, 0.25f);
  EXPECT_FLOAT_EQ(hit.v, 0.5f);
}

}  // namespace
}  // namespace alabaster
