#include "core/geometry/instance_cell.h"

#include <gtest/gtest.h>

#include <random>
#include <set>

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

struct Blocked final : HitFilter {
  explicit Blocked(uint32_t passed) : passed_(passed) {}
  bool stops(const TriangleHit& hit) const noexcept override { return hit.instance != passed_; }

 private:
  const uint32_t passed_;
};

class InstanceCellTest : public ::testing::Test {
 protected:
  // Number i is in cell `cell_of(i)`.
  template <class CellOf>
  InstanceCells cells(const std::vector<Placement>& placements, const CellOf& cell_of, uint32_t hidden = ~0u) {
    std::vector<CellInstances> parts(3);
    std::vector<std::vector<uint32_t>> numbers(3);
    std::vector<uint32_t> slots;
    for (uint32_t i = 0; i < placements.size(); ++i) {
      const uint32_t cell = cell_of(i);
      slots.push_back(cell * InstanceCells::kMost + static_cast<uint32_t>(numbers[cell].size()));
      numbers[cell].push_back(i);
      parts[cell].placements.push_back(placements[i]);
      parts[cell].hidden.push_back(i == hidden);
    }
    InstanceCells array;
    array.slots = std::make_shared<const std::vector<uint32_t>>(std::move(slots));
    for (size_t i = 0; i < parts.size(); ++i) {
      parts[i].numbers = std::make_shared<const std::vector<uint32_t>>(numbers[i]);
      array.cells.push_back(build_instance_cell(device_, cube_, std::move(parts[i])));
    }
    return array;
  }
  static uint32_t by_thirds(uint32_t i) { return i / InstanceCells::kMost; }

  std::vector<Ray> rays(int count) {
    std::mt19937 random(3);
    std::uniform_real_distribution<float> number(-1, 1);
    std::vector<Ray> all;
    for (int i = 0; i < count; ++i)
      all.push_back({{2 * number(random), 2 * number(random), 3}, {number(random) * 0.3f, number(random) * 0.3f, -1}});
    return all;
  }

  const std::shared_ptr<const std::vector<uint32_t>> only_ = std::make_shared<const std::vector<uint32_t>>(1, 0);
  test::RecordingSink sink_;
  std::shared_ptr<TraceDevice> device_ = make_trace_device(sink_.sink());
  std::shared_ptr<const ObjectScene> cube_ = build_object_scene(device_, build_mesh(test::cube_cage(), {}, {}), {});
};

// The oracle is Embree's own instancing.
TEST_F(InstanceCellTest, RaysMeetTheSameAsAmongInstancesThatStandAlone) {
  const std::vector<Placement> placements = random_placements();
  std::vector<InstancePlacement> alone;
  for (const Placement& p : placements) alone.push_back({cube_, p.object_to_world});
  const auto expected = build_instanced_scene(device_, alone);
  const auto scene = build_instanced_scene(device_, {}, {}, {cells(placements, by_thirds)});
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

TEST_F(InstanceCellTest, IndicesFollowThoseThatStandAloneAndOfEarlierArrays) {
  const auto at = [](float x) {
    const Affine moved{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {x, 0, 0}};
    return Placement{moved, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-x, 0, 0}}};
  };
  const auto in_one = [](uint32_t) { return 1u; };
  const auto scene =
      build_instanced_scene(device_, {{cube_, at(0).object_to_world}, {nullptr, {}}}, {},
                            {cells({at(10), at(20), at(30)}, in_one), cells({at(40), at(50)}, in_one, 0)});
  const auto met = [&](float x) {
    TriangleHit hit;
    const Ray ray{{x, 0.1f, 5}, {0, 0, -1}};
    EXPECT_EQ(scene->intersect(ray, &hit), scene->occluded(ray));
    return scene->intersect(ray, &hit) ? int(hit.instance) : -1;
  };
  EXPECT_EQ(met(0), 0);
  EXPECT_EQ(met(10), 2);
  EXPECT_EQ(met(30), 4);
  EXPECT_EQ(met(40), -1) << "hidden";
  EXPECT_EQ(met(50), 6);
  const Ray along{{5, 0.2f, 0.1f}, {1, 0, 0}};
  TriangleHit hit;
  const Blocked second(2);
  ASSERT_TRUE(scene->intersect(along, &hit, &second));
  EXPECT_EQ(hit.instance, 3u) << "the filter lets the ray pass the first";
  EXPECT_FLOAT_EQ(hit.t, 14);
  EXPECT_TRUE(scene->occluded({{5, 0.2f, 0.1f}, {1, 0, 0}, 10}));
  EXPECT_FALSE(scene->occluded({{5, 0.2f, 0.1f}, {1, 0, 0}, 10}, &second));
}

// Which cell an instance is in must show nowhere.
TEST_F(InstanceCellTest, FirstOfCoincidentInstancesIsHit) {
  std::vector<Placement> placements = random_placements();
  for (uint32_t i = 0; i < kCount; i += 2) placements[i + 1] = placements[i];
  const auto scene = build_instanced_scene(device_, {}, {}, {cells(placements, by_thirds)});
  const auto other =
      build_instanced_scene(device_, {}, {}, {cells(placements, [](uint32_t i) { return (i * 2654435761u) >> 31; })});
  for (const Ray& ray : rays(5000)) {
    TriangleHit a, b;
    ASSERT_EQ(scene->intersect(ray, &a), other->intersect(ray, &b));
    ASSERT_EQ(a.instance, b.instance);
    EXPECT_EQ(a.instance % 2, 0u);
    EXPECT_EQ(a.t, b.t);
  }
}

// Embree answers any hit of so small a triangle with its first corner.
TEST_F(InstanceCellTest, HitsOfTheSmallestTrianglesHaveTheirBarycentrics) {
  const float s = 0x1p-36f;
  Mesh mesh;
  mesh.points = {Vec3f(0, 0, 2) * s, Vec3f(4, 0, 2) * s, Vec3f(0, 4, 2) * s};
  mesh.triangles = {{0, 1, 2}};
  CellInstances one{
      only_, {{{{0, 2, 0}, {-2, 0, 0}, {0, 0, 2}, {0, 0, 0}}, {{0, -0.5f, 0}, {0.5f, 0, 0}, {0, 0, 0.5f}}}}, {false}};
  InstanceCells array;
  array.slots = std::make_shared<const std::vector<uint32_t>>(std::vector<uint32_t>{0});
  array.cells = {build_instance_cell(device_, build_object_scene(device_, mesh, {}), std::move(one))};
  const auto scene = build_instanced_scene(device_, {}, {}, {array});
  TriangleHit hit;
  ASSERT_TRUE(scene->intersect({Vec3f(-4, 2, 10) * s, {0, 0, -1}}, &hit));
  EXPECT_FLOAT_EQ(hit.u, 0.25f);
  EXPECT_FLOAT_EQ(hit.v, 0.5f);
}

TEST_F(InstanceCellTest, CancelledBuildStops) {
  CellInstances one{only_, {Placement{}}, {false}};
  EXPECT_EQ(build_instance_cell(device_, cube_, std::move(one), [] { return true; }), nullptr);
  EXPECT_TRUE(sink_.all().empty());
}

// A scale of 1e-20 takes rays from a unit away, but none from 1e4.
TEST_F(InstanceCellTest, ReportsTheLargestTraceableDistance) {
  const Affine tiny{{1e-11f, 0, 0}, {0, 1e-11f, 0}, {0, 0, 1e-11f}, {0, 0, 0}};
  const Affine inverse{{1e11f, 0, 0}, {0, 1e11f, 0}, {0, 0, 1e11f}, {0, 0, 0}};
  for (const bool hidden : {false, true}) {
    CellInstances one{only_, {{tiny, inverse}}, {hidden}};
    const auto cell = build_instance_cell(device_, cube_, std::move(one));
    ASSERT_TRUE(cell);
    EXPECT_TRUE(cell->is_traceable_from(1));
    EXPECT_EQ(cell->is_traceable_from(1e7f), hidden);
  }
}

}  // namespace
}  // namespace alabaster
