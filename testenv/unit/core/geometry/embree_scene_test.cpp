#include "core/geometry/embree_scene.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#include <tbb/task_group.h>
#include <unistd.h>
#include <xmmintrin.h>

#include <array>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <memory>
#include <thread>

#include "testenv/support/cages.h"

namespace alabaster {
namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

class EmbreeScene : public ::testing::Test {
 protected:
  std::shared_ptr<const ObjectScene> build(const Mesh& mesh) { return build_object_scene(device_, mesh, {}); }
  std::shared_ptr<const ObjectScene> cube() { return build(build_mesh(test::cube_cage(), {}, {})); }

  test::RecordingSink sink_;
  std::shared_ptr<TraceDevice> device_ = make_trace_device(sink_.sink());
};

// Embree itself says that every hit of a triangle this small is at its first corner.
TEST_F(EmbreeScene, HitsOfTheSmallestTrianglesHaveTheirBarycentricsToo) {
  for (const int exponent : {-20, -30, -36, -40}) {
    const float s = std::ldexp(1.0f, exponent);
    Mesh mesh;
    mesh.points = {Vec3f(0, 0, 2) * s, Vec3f(4, 0, 2) * s, Vec3f(0, 4, 2) * s};
    mesh.triangles = {{0, 1, 2}};
    const auto object = build(mesh);
    TriangleHit hit;
    ASSERT_TRUE(object->intersect({Vec3f(1, 2, 5) * s, {0, 0, -0.5f}}, &hit)) << exponent;
    EXPECT_FLOAT_EQ(hit.u, 0.25f) << exponent;
    EXPECT_FLOAT_EQ(hit.v, 0.5f) << exponent;
    // Turned about z, twice as large, and moved.
    const Affine placement{{0, 2, 0}, {-2, 0, 0}, {0, 0, 2}, Vec3f(3, 1, 0) * s};
    const auto top = build_instanced_scene(device_, {{nullptr, Affine()}, {object, placement}});
    ASSERT_TRUE(top->intersect({placement.point(Vec3f(1, 2, 2) * s) + Vec3f(0, 0, 3) * s, {0, 0, -1}}, &hit));
    EXPECT_EQ(hit.instance, 1u);
    EXPECT_FLOAT_EQ(hit.u, 0.25f) << exponent;
    EXPECT_FLOAT_EQ(hit.v, 0.5f) << exponent;
  }
}

TEST_F(EmbreeScene, AllHitsComeInOrderAndOnce) {
  Mesh mesh;
  for (const float z : {3.0f, 1.0f, 2.0f, 1.0f}) {  // two coincide
    const auto first = static_cast<uint32_t>(mesh.points.size());
    mesh.points.insert(mesh.points.end(), {{0, 0, z}, {4, 0, z}, {0, 4, z}});
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  const auto object = build(mesh);
  std::pmr::vector<TriangleHit> hits(7);
  const auto triangles = [&](const Ray& ray) {
    object->intersect_all(ray, &hits);
    std::vector<uint32_t> found;
    for (const auto& h : hits) found.push_back(h.triangle);
    return found;
  };
  EXPECT_EQ(triangles({{1, 2, 0}, {0, 0, 0.5f}}), (std::vector<uint32_t>{1, 3, 2, 0}));
  EXPECT_FLOAT_EQ(hits[2].t, 4);
  EXPECT_FLOAT_EQ(hits[2].u, 0.25f);
  EXPECT_FLOAT_EQ(hits[2].v, 0.5f);
  EXPECT_EQ(triangles({{1, 2, 0}, {0, 0, 1}, 2.0f}), (std::vector<uint32_t>{1, 3, 2}));
  EXPECT_EQ(triangles({{1, 2, 9}, {0, 0, -1}}), (std::vector<uint32_t>{0, 2, 1, 3}));
  EXPECT_TRUE(triangles({{3, 3, 0}, {0, 0, 1}}).empty());
  EXPECT_TRUE(triangles({{kNaN, 2, 0}, {0, 0, 1}}).empty());
  // The nearest alone is found as ever.
  TriangleHit hit;
  EXPECT_TRUE(object->intersect({{1, 2, 0}, {0, 0, 1}}, &hit));
  EXPECT_FLOAT_EQ(hit.t, 1);
}

// Four instances in a row along x, each of another kind; hand-computed distances.
TEST_F(EmbreeScene, InstancesAreFoundUnderTheirTransforms) {
  const auto object = cube();
  const std::vector<InstancePlacement> placements = {
      {object, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {10, 0, 0}}},    // moved: x in [9, 11]
      {nullptr, {}},                                              // keeps its index
      {object, {{0, 2, 0}, {-3, 0, 0}, {0, 0, 1}, {20, 0, 0}}},   // x -> 2y, y -> -3x: [17, 23] x [-2, 2]
      {object, {{-2, 0, 0}, {0, 1, 0}, {0, 0, 1}, {30, 5, 0}}},   // mirrored: [28, 32] x [4, 6]
      {object, {{1, 0, 0}, {0.5f, 1, 0}, {0, 0, 4}, {40, 0, 0}}}  // sheared along x by y, z in [-4, 4]
  };
  const auto scene = build_instanced_scene(device_, placements);
  TriangleHit hit;
  const auto expect_hit = [&](const Ray& ray, uint32_t instance, float t) {
    ASSERT_TRUE(scene->intersect(ray, &hit));
    EXPECT_EQ(hit.instance, instance);
    EXPECT_NEAR(hit.t, t, 1e-5f * t);
    EXPECT_TRUE(scene->occluded(ray));
    Ray shorter = ray;
    shorter.tmax = t * 0.999f;
    EXPECT_FALSE(scene->intersect(shorter, &hit));
    EXPECT_FALSE(scene->occluded(shorter));
  };
  expect_hit({{0, 0.3f, 0.2f}, {1, 0, 0}}, 0, 9);
  expect_hit({{15, 0.3f, 0.2f}, {0.25f, 0, 0}}, 2, 8);  // 2 / 0.25
  expect_hit({{20.5f, 9, 0}, {0, -2, 0}}, 2, 3.5f);
  expect_hit({{25, 5.5f, 0}, {1, 0, 0}}, 3, 3);
  expect_hit({{50, 0.5f, 0}, {-1, 0, 0}}, 4, 8.75f);  // right face at 40 + 1 + 0.5 * 0.5
  expect_hit({{40, 0, 10}, {0, 0, -3}}, 4, 2);
  EXPECT_FALSE(scene->intersect({{25, 3, 0}, {1, 0, 0}, 5.0f}, &hit));
}

TEST_F(EmbreeScene, EmptyScenesAreNeverHit) {
  TriangleHit hit;
  const Ray ray{{0, 0, 5}, {0, 0, -1}};
  const auto nothing = build_instanced_scene(device_, {});
  EXPECT_FALSE(nothing->intersect(ray, &hit));
  EXPECT_FALSE(nothing->occluded(ray));
  const auto empty = build(Mesh());
  ASSERT_TRUE(empty);
  EXPECT_FALSE(empty->intersect(ray, &hit));
  EXPECT_FALSE(build_instanced_scene(device_, {{empty, {}}})->intersect(ray, &hit));
  Affine bad;
  bad.x.x = kNaN;
  const auto object = cube();
  const auto scene = build_instanced_scene(device_, {{object, bad}, {object, {}}});
  ASSERT_TRUE(scene->intersect(ray, &hit));
  EXPECT_EQ(hit.instance, 1u);
  EXPECT_TRUE(sink_.all().empty());
}

TEST_F(EmbreeScene, BadRaysMissInsteadOfAborting) {
  const auto object = cube();
  const auto scene = build_instanced_scene(device_, {{object, {}}});
  std::vector<Ray> rays;
  for (float bad : {kNaN, kInf, -kInf, 1e19f, -1e19f, 2e18f})
    for (int axis = 0; axis < 3; ++axis) {
      Ray org{{0, 0, 5}, {0, 0, -1}}, dir = org;
      org.org[axis] = bad;
      dir.dir[axis] = bad;
      rays.insert(rays.end(), {org, dir});
    }
  for (float tmax : {kNaN, -1.0f, -kInf}) rays.push_back({{0, 0, 5}, {0, 0, -1}, tmax});
  for (const Ray& ray : rays) {
    TriangleHit hit;
    EXPECT_FALSE(is_traceable(ray));
    EXPECT_FALSE(object->intersect(ray, &hit));
    EXPECT_FALSE(scene->intersect(ray, &hit));
    EXPECT_FALSE(scene->occluded(ray));
  }
  TriangleHit hit;
  EXPECT_FALSE(scene->intersect({{0, 0, 5}, {0, 0, 0}}, &hit));  // no direction: traceable, and misses
  EXPECT_FALSE(scene->intersect({{0, 0, 5}, {0, 0, -1}, 0.0f}, &hit));
}

Affine scaled(float x, float y, float z) {
  return {{x, 0, 0}, {0, y, 0}, {0, 0, z}, {0, 0, 0}};
}

// Embree transforms rays into object space and aborts if they are too large there, so placements must be checked
// before.
TEST_F(EmbreeScene, ExtremePlacementsMissInsteadOfAborting) {
  const auto object = cube();
  for (int exponent = -45; exponent <= 38; ++exponent) {
    const auto s = static_cast<float>(std::pow(10.0, exponent));
    for (Affine placement : {scaled(s, s, s), scaled(s, -1, 1), scaled(1, 1, s), scaled(s, 1, 1 / s)})
      for (float shift : {0.0f, 3.0f, 1e16f}) {
        placement.t.x = shift;
        const auto scene = build_instanced_scene(device_, {{object, placement}, {object, {}}});
        for (float distance : {0.0f, 5.0f, 1e5f, 9e16f})
          for (const Vec3f& direction : {Vec3f(0, 0, -1), Vec3f(0.6f, 0, -0.8f), Vec3f(9e16f, 1, 1), Vec3f(0, s, s)}) {
            const Ray ray{direction * (distance > 0 ? -distance / max_abs_component(direction) : 0.0f), direction};
            TriangleHit hit;
            EXPECT_EQ(scene->intersect(ray, &hit), scene->occluded(ray)) << exponent;
          }
      }
  }
}

TEST_F(EmbreeScene, TraceablePlacementsAreTracedFromTheDistancePromised) {
  const auto object = cube();
  for (int exponent = -12; exponent <= 12; ++exponent) {
    const auto s = static_cast<float>(std::pow(10.0, exponent));
    ASSERT_TRUE(is_traceable(scaled(s, s, s), 1000 * s)) << exponent;
    const auto scene = build_instanced_scene(device_, {{object, scaled(s, s, s)}});
    TriangleHit hit;
    ASSERT_TRUE(scene->intersect({{0.25f * s, 0.5f * s, 1000 * s}, {0, 0, -1}}, &hit)) << exponent;
    EXPECT_NEAR(hit.t / s, 999, 0.01f);
  }
  EXPECT_FALSE(is_traceable(scaled(1e-20f, 1, 1), 1));
  EXPECT_FALSE(is_traceable(scaled(1e-10f, 1, 1), 1e8f));
  EXPECT_TRUE(is_traceable(scaled(1e-10f, 1, 1), 1e6f));
  EXPECT_FALSE(is_traceable(scaled(1e-15f, 1e-15f, 1e-15f), 0));  // no inverse in floats
  EXPECT_FALSE(is_traceable(scaled(1e15f, 1e15f, 1e15f), 0));
}

TEST_F(EmbreeScene, BuildStopsWhenCancelled) {
  RefinementOptions options;
  options.level = 6;
  const Mesh mesh = build_mesh(test::cube_cage(SubdivisionScheme::catmull_clark), options, {});
  EXPECT_EQ(build_object_scene(device_, mesh, [] { return true; }), nullptr);
  std::atomic<int> asked{0};
  EXPECT_EQ(build_object_scene(device_, mesh, [&] { return ++asked > 2; }), nullptr);
  EXPECT_GT(asked, 2);
  EXPECT_NE(build_object_scene(device_, mesh, [] { return false; }), nullptr);
  EXPECT_TRUE(sink_.all().empty());  // a stopped build is no fault
}

TEST_F(EmbreeScene, BuildStaysInTheArenaOfItsCaller) {
  RefinementOptions options;
  options.level = 6;
  const Mesh mesh = build_mesh(test::cube_cage(SubdivisionScheme::catmull_clark), options, {});
  tbb::task_arena arena(1);
  const auto caller = std::this_thread::get_id();
  std::atomic<int> elsewhere{0}, asked{0};
  arena.execute([&] {
    build_object_scene(device_, mesh, [&] {
      ++asked;
      if (std::this_thread::get_id() != caller) ++elsewhere;
      return false;
    });
  });
  EXPECT_GT(asked, 1);
  EXPECT_EQ(elsewhere, 0);
}

// Runs in a process of its own, whose exit status is the result.
enum Outcome { kBuilt = 0, kNull = 1, kThrown = 2 };

template <class Build>
[[noreturn]] void build_in_little_memory(size_t spare_bytes, const Build& build) {
  size_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  const rlim_t limit = pages * static_cast<size_t>(sysconf(_SC_PAGESIZE)) + spare_bytes;
  const rlimit limits{limit, limit};
  setrlimit(RLIMIT_AS, &limits);
  tbb::task_arena arena(1);
  Outcome outcome = kThrown;
  try {
    arena.execute([&] { outcome = build() ? kBuilt : kNull; });
  } catch (const std::bad_alloc&) {
  }
  std::_Exit(outcome);
}

TEST_F(EmbreeScene, ABuildThatMemoryDoesNotSufficeForThrows) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers end the process when memory runs out";
#else
  ::testing::FLAGS_gtest_death_test_style = "threadsafe";
  // 524288 triangles: 9.4 MB of buffers fit, the 16.8 MB of references that the build begins with do not.
  const Mesh mesh = build_mesh(test::grid_cage(512), {}, {});
  EXPECT_EXIT(build_in_little_memory(size_t(20) << 20, [&] { return build(mesh) != nullptr; }),
              ::testing::ExitedWithCode(kThrown), "");
  const std::vector<InstancePlacement> placements(100000, {cube(), {}});
  // 600 bytes and more for each of them.
  EXPECT_EXIT(
      build_in_little_memory(size_t(16) << 20, [&] { return build_instanced_scene(device_, placements) != nullptr; }),
      ::testing::ExitedWithCode(kThrown), "");
  EXPECT_NE(build(mesh), nullptr) << "with memory enough";
#endif
}

// Four threads, so that some are at work when the budget refuses one.
// promise: pipeline.memory.embree
TEST_F(EmbreeScene, ABuildStopsAtTheMemoryLimitAndTheDeviceGoesOn) {
  const Mesh mesh = build_mesh(test::grid_cage(256), {}, {});  // 131072 triangles
  const auto budget = std::make_shared<MemoryBudget>();
  const auto device = make_trace_device(sink_.sink(), budget);
  tbb::task_arena arena(4);
  const auto build_one = [&] {
    std::shared_ptr<const ObjectScene> object;
    arena.execute([&] { object = build_object_scene(device, mesh, {}); });
    return object;
  };
  auto object = build_one();
  const size_t held = budget->in_use(MemoryUse::tracing);
  EXPECT_GT(held, object->memory_bytes() / 2);
  EXPECT_LT(held, object->memory_bytes() * 2);
  object = nullptr;
  const size_t idle = budget->in_use();
  EXPECT_LT(idle, held / 10);
  for (size_t limit = idle + (held - idle) / 8; limit < held; limit += (held - idle) / 8) {
    budget->set_limit(limit);
    try {
      build_one();
      ADD_FAILURE() << "it fits " << limit << " of " << held;
    } catch (const MemoryRefused& refused) {
      const std::string text = refused.what();
      EXPECT_EQ(text.find("a hierarchy of triangles needs "), 0u) << text;
      EXPECT_NE(text.find("of the memory limit of"), std::string::npos) << text;
    }
    EXPECT_TRUE(sink_.all().empty()) << "who asked for it reports it";
    EXPECT_LE(budget->in_use(), idle + (size_t(1) << 20)) << "what was built is given back";
  }
  budget->set_limit(MemoryBudget::kUnlimited);
  EXPECT_NE(build_one(), nullptr) << "with memory enough";
}

TEST_F(EmbreeScene, LeavesTheFloatingPointModeOfTheHostAlone) {
  const unsigned before = _mm_getcsr() & ~0x3fu;  // without the sticky exception flags
  const auto scene = build_instanced_scene(device_, {{cube(), {}}});
  TriangleHit hit;
  scene->intersect({{0, 0, 5}, {0, 0, -1}}, &hit);
  EXPECT_EQ(_mm_getcsr() & ~0x3fu, before);
}

TEST_F(EmbreeScene, ScenesOutliveTheirMakers) {
  auto object = cube();
  auto scene = build_instanced_scene(device_, {{object, {}}});
  object.reset();
  device_.reset();
  TriangleHit hit;
  EXPECT_TRUE(scene->intersect({{0, 0, 5}, {0, 0, -1}}, &hit));
}

// At each time a moving instance, and a mesh that deforms, are hit as still ones of that shape and place.
TEST_F(EmbreeScene, MovingObjectIsHitAtTheRaysTime) {
  const Mesh still = build_mesh(test::cube_cage(), {}, {});
  const auto larger_by = [&](float factor) {
    std::vector<Vec3f> points = still.points;
    for (Vec3f& p : points) p = p * factor;
    return points;
  };
  Mesh grown = still;
  for (const float factor : {3.0f, 2.0f}) grown.later_poses.push_back({larger_by(factor), {}});
  const std::vector<Affine> poses = {
      {}, {{1, 0, 0}, {0, 2, 0}, {0, 0, 1}, {4, 0, 0}}, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {8, 8, 0}}};
  const auto moving = build_instanced_scene(device_, {{build(grown), {}, poses}});
  ASSERT_TRUE(moving);
  int hits = 0;
  for (const float time : {0.0f, 0.1f, 0.25f, 0.5f, 0.8f, 1.0f}) {
    Mesh then = still;
    for (uint32_t i = 0; i < then.points.size(); ++i) then.points[i] = grown.point_at(i, time);
    const auto posed_scene = build_instanced_scene(device_, {{build(then), posed(poses, time)}});
    for (int x = -20; x < 60; ++x) {
      const Ray ray{{static_cast<float>(x) * 0.25f + 0.01f, 0.3f, 20}, {0.02f, 0.1f, -1}, kInf, time};
      TriangleHit moved, expected;
      const bool found = moving->intersect(ray, &moved);
      ASSERT_EQ(found, posed_scene->intersect(ray, &expected)) << x << " at " << time;
      EXPECT_EQ(moving->occluded(ray), found);
      if (!found) continue;
      ++hits;
      EXPECT_EQ(moved.triangle, expected.triangle);
      EXPECT_NEAR(moved.t, expected.t, 1e-4);
      EXPECT_EQ(moved.time, time);
      std::pmr::vector<TriangleHit> all;
      build(grown)->intersect_all({{0.1f, 0.2f, 9}, {0, 0, -1}, kInf, time}, &all);
      ASSERT_EQ(all.size(), 2u);
      EXPECT_EQ(all[0].time, time);
    }
  }
  EXPECT_GT(hits, 50);
}

TEST_F(EmbreeScene, ObjectThatInvertsDuringTheShutterIsNotTraceable) {
  const Affine there{}, mirrored{{-1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}};
  EXPECT_TRUE(is_traceable(std::vector<Affine>{there, there}, 10));
  EXPECT_FALSE(is_traceable(std::vector<Affine>{there, mirrored}, 10));
}

// Leaves nothing on the stack that would pass for what stood there before.
__attribute__((noinline)) void overwrite_stack() {
  std::array<volatile char, 16384> bytes;
  for (volatile char& byte : bytes) byte = 0x3f;
}

// Embree's scenes hold task groups. A host that cancels work of its own made TBB follow their pointers to a loop that
// had ended.
TEST_F(EmbreeScene, OutlivesTheLoopThatBuiltIt) {
  std::vector<std::shared_ptr<const ObjectScene>> scenes(4);
  tbb::parallel_for(size_t(0), scenes.size(), [&](size_t i) { scenes[i] = cube(); });
  overwrite_stack();
  tbb::task_group_context context;
  const auto cancel = [&](int) { context.cancel_group_execution(); };
  tbb::parallel_for(
      0, 2, [&](int) { tbb::parallel_for(0, 2, cancel); }, context);
  for (const auto& scene : scenes) EXPECT_TRUE(scene);
}

}  // namespace
}  // namespace alabaster
