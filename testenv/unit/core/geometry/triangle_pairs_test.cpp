#include "core/geometry/triangle_pairs.h"

#include <gtest/gtest.h>

#include <random>

#include "core/geometry/embree_scene.h"
#include "testenv/support/cages.h"

namespace alabaster {
namespace {

// Embree has the first mesh as quads, and the second, whose triangles start at other corners, as triangles.
class QuadTracing : public ::testing::Test {
 protected:
  QuadTracing() {
    std::mt19937 random(7);
    std::uniform_real_distribution<float> uniform(-0.3f, 0.3f);
    Cage cage = test::grid_cage(6);
    for (Vec3f& p : cage.points) p = p + Vec3f(uniform(random), uniform(random), uniform(random)) * 0.5f;
    quads_ = build_mesh(cage, {}, {});
    triangles_ = quads_;
    for (Corners& c : triangles_.triangles) turn(&c, 1);
    EXPECT_TRUE(are_pairs(quads_.triangles));
    EXPECT_FALSE(are_pairs(triangles_.triangles));
    device_ = make_trace_device(sink_.sink());
    as_quads_ = build_object_scene(device_, quads_, {});
    as_triangles_ = build_object_scene(device_, triangles_, {});
  }
  static Vec3f point(const Mesh& mesh, const TriangleHit& hit) {
    const auto c = mesh.corners_at(hit.triangle, 0);
    return c[0] * (1 - hit.u - hit.v) + c[1] * hit.u + c[2] * hit.v;
  }
  void expect_same(const TriangleHit& quad, const TriangleHit& triangle) const {
    EXPECT_EQ(quad.triangle, triangle.triangle);
    EXPECT_NEAR(quad.t, triangle.t, 1e-5f);
    EXPECT_LT(length(point(quads_, quad) - point(triangles_, triangle)), 1e-5f);
    EXPECT_LT(length(normalize(quad.normal) - normalize(triangle.normal)), 1e-5f);
  }
  Ray random_ray() {
    const Vec3f from(across_(random_), across_(random_), 4), to(across_(random_), across_(random_), 0);
    return {from, normalize(to - from)};
  }

  test::RecordingSink sink_;
  std::shared_ptr<TraceDevice> device_;
  Mesh quads_, triangles_;
  std::shared_ptr<const ObjectScene> as_quads_, as_triangles_;
  std::mt19937 random_{11};
  std::uniform_real_distribution<float> across_{-0.5f, 6.5f};
};

TEST_F(QuadTracing, FindsTheTrianglesThatTrianglesHave) {
  const auto quads = build_instanced_scene(device_, {{as_quads_, Affine()}}),
             triangles = build_instanced_scene(device_, {{as_triangles_, Affine()}});
  size_t hits = 0;
  for (int i = 0; i < 20000; ++i) {
    const Ray ray = random_ray();
    TriangleHit quad, triangle;
    ASSERT_EQ(as_quads_->intersect(ray, &quad), as_triangles_->intersect(ray, &triangle));
    ASSERT_EQ(quads->occluded(ray), triangles->occluded(ray));
    TriangleHit placed;
    if (!quads->intersect(ray, &placed)) continue;
    ++hits;
    expect_same(quad, triangle);
    expect_same(placed, triangle);
  }
  EXPECT_GT(hits, 10000u);
}

TEST_F(QuadTracing, FiltersAndAllHitsNameTheTrianglesToo) {
  class Passes final : public HitFilter {
   public:
    explicit Passes(uint32_t triangle) : triangle_(triangle) {}
    bool stops(const TriangleHit& hit) const noexcept override { return hit.triangle != triangle_; }

   private:
    uint32_t triangle_;
  };
  const auto quads = build_instanced_scene(device_, {{as_quads_, Affine()}});
  size_t several = 0;
  for (int i = 0; i < 20000; ++i) {
    // Along the sheet, so that most meet it more than once.
    const Ray ray{{-1, across_(random_), 0.05f}, normalize(Vec3f(8, across_(random_) - 3, -0.1f))};
    std::pmr::vector<TriangleHit> quad, triangle;
    as_quads_->intersect_all(ray, &quad);
    as_triangles_->intersect_all(ray, &triangle);
    ASSERT_EQ(quad.size(), triangle.size());
    for (size_t k = 0; k < quad.size(); ++k) EXPECT_EQ(quad[k].triangle, triangle[k].triangle);
    if (quad.size() < 2) continue;
    ++several;
    const Passes filter(quad[0].triangle);
    TriangleHit next;
    ASSERT_TRUE(quads->intersect(ray, &next, &filter));
    EXPECT_EQ(next.triangle, quad[1].triangle);
  }
  EXPECT_GT(several, 100u);
}

// Embree itself says that every hit of a triangle this small is at its first corner.
TEST_F(QuadTracing, HitsOfTheSmallestQuadsHaveTheirBarycentrics) {
  for (const int exponent : {0, -20, -36, -40}) {
    const float s = std::ldexp(1.0f, exponent);
    Mesh mesh;
    mesh.points = {Vec3f(0, 0, 2) * s, Vec3f(4, 0, 2) * s, Vec3f(0, 4, 2) * s, Vec3f(4, 4, 2) * s};
    mesh.triangles = {{0, 1, 2}, {3, 2, 1}};
    ASSERT_TRUE(are_pairs(mesh.triangles));
    const auto object = build_object_scene(device_, mesh, {});
    TriangleHit hit;
    for (const uint32_t second : {0u, 1u}) {
      const Vec3f from = second ? Vec3f(3, 3, 5) : Vec3f(1, 2, 5);
      ASSERT_TRUE(object->intersect({from * s, {0, 0, -0.5f}}, &hit)) << exponent;
      EXPECT_EQ(hit.triangle, second) << exponent;
      EXPECT_FLOAT_EQ(hit.u, 0.25f) << exponent;
      EXPECT_FLOAT_EQ(hit.v, second ? 0.25f : 0.5f) << exponent;
    }
  }
}

}  // namespace
}  // namespace alabaster
