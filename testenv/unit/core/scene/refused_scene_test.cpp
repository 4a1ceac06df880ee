// A scene that memory does not hold is refused as a whole, in the name of the prim that asks for more.
#include <gtest/gtest.h>

#include "core/scene/snapshot_compiler.h"
#include "testenv/support/cages.h"
#include "testenv/support/medium_bodies.h"
#include "testenv/support/memory_texture.h"
#include "testenv/support/scene_builder.h"

namespace alabaster {
namespace {

using testing::SceneBuilder;

constexpr size_t kMiB = size_t(1) << 20;

// The budget counts what the compiler takes, and the interiors of the meshes; BVHs of meshes are on another device.
class SceneWithoutMemory : public ::testing::Test {
 protected:
  std::shared_ptr<const MeshPrototype> sphere(int rings) {
    auto made = std::make_shared<MeshPrototype>();
    made->mesh = testing::sphere_mesh(1, rings, true);
    made->object = b_.prototype(made->mesh)->object;
    made->interior.count_in(memory_);
    return made;
  }
  std::shared_ptr<const DisneyMaterial> wax(float scatter_distance) {
    DisneyParameters p;
    p.base_color = Rgb(0.98f);
    p.scatter_distance = Rgb(scatter_distance);
    return b_.material(p);
  }
  std::shared_ptr<const SceneSnapshot> compile() { return compiler_.compile(b_.description, ++number_); }

  /// With `bytes` more than are in use the scene is refused in the prim's name, and compiled once there is more.
  void expect_refused(size_t bytes, const std::string& prim, const char* text) {
    memory_->set_limit(memory_->in_use() + bytes);
    for (int i = 0; i < 2; ++i) try {
        compile();
        ADD_FAILURE() << "it fits";
      } catch (const MemoryRefused& refused) {
        EXPECT_EQ(refused.prim(), prim);
        EXPECT_EQ(std::string(refused.what()).find(text), 0u) << refused.what();
        EXPECT_NE(std::string(refused.what()).find("raise memoryLimit, or "), std::string::npos) << refused.what();
        EXPECT_GT(refused.bytes(), 0u);
      }
    EXPECT_TRUE(sink_.all().empty()) << "who catches the exception reports it";
    memory_->set_limit(MemoryBudget::kUnlimited);
    whole_ = compile();
    ASSERT_TRUE(whole_ && whole_->top);
    EXPECT_EQ(whole_->instances.size(), b_.description.instances.size());
  }

  SceneBuilder b_;
  test::RecordingSink sink_;
  std::shared_ptr<MemoryBudget> memory_ = std::make_shared<MemoryBudget>();
  SnapshotCompiler compiler_{make_trace_device(sink_.sink(), memory_), sink_.sink()};
  uint64_t number_ = 0;
  std::shared_ptr<const SceneSnapshot> whole_;
};

// 84 bytes a triangle.
TEST_F(SceneWithoutMemory, ABodyIsNamed) {
  const auto coarse = sphere(8), fine = sphere(96);
  b_.add(coarse, wax(50), testing::moved(-3)).add(fine, wax(50)).add(fine, wax(50), testing::moved(3));
  b_.add(testing::constant_dome(1, true));
  for (const size_t i : {size_t(1), size_t(2)}) b_.description.instances[i].name = "/fine";
  expect_refused(kMiB, "/fine", "the interior of a mesh of ");
  EXPECT_EQ(whole_->bodies.size(), 3u);
}

// The distance grid of a mesh takes 10 MB while it is built.
TEST_F(SceneWithoutMemory, TheDistancesOfABodyAreNoLess) {
  b_.add(sphere(24), wax(0.01f)).add(testing::constant_dome(1, false));
  expect_refused(4 * kMiB, "/test/0", "");
}

// Embree takes more than 500 bytes for an instance.
TEST_F(SceneWithoutMemory, ASubsurfaceSetIsNamedByItsFirstMember) {
  constexpr size_t kMembers = 3000;
  const auto ball = sphere(6);
  for (size_t i = 0; i < kMembers; ++i) {
    b_.add(ball, wax(50), testing::moved(double(i % 50)));
    b_.description.instances.back().subsurface_set = "set";
  }
  b_.add(testing::constant_dome(1, true));
  expect_refused(kMembers * sizeof(Instance) + kMiB / 2, "/test/0",
                 "a hierarchy of the meshes of a subsurfaceSet needs ");
}

// Three numbers a texel.
TEST_F(SceneWithoutMemory, ALightWithAnImageIsNamed) {
  b_.add(sphere(8), b_.material({}));
  LightParameters dome;
  dome.type = LightType::dome;
  dome.name = "/sky";
  dome.texture = std::make_shared<testing::MemoryTexture>(512, std::vector<Rgb>(512 * 256, Rgb(0.5f)));
  b_.add(dome).add(testing::constant_dome(1, true));
  expect_refused(kMiB / 2, "/sky", "");
}

TEST_F(SceneWithoutMemory, AMeshThatEmitsIsNamed) {
  DisneyParameters glow;
  glow.emission = Rgb(2.0f);
  b_.add(sphere(96), b_.material(glow));
  expect_refused(kMiB, "/test/0", "");
  EXPECT_GT(memory_->in_use(MemoryUse::lights), kMiB);
}

TEST_F(SceneWithoutMemory, AMeshLightCountsOnceHoweverManySnapshotsShareIt) {
  DisneyParameters glow;
  glow.emission = Rgb(2.0f);
  b_.add(sphere(96), b_.material(glow));
  const auto first = compile();
  const size_t held = memory_->in_use(MemoryUse::lights);
  EXPECT_EQ(held, std::get<MeshLight>(first->lights.lights()[0]).memory_bytes());
  const auto second = compile();
  EXPECT_EQ(memory_->in_use(MemoryUse::lights), held);
}

TEST_F(SceneWithoutMemory, TheTopLevelIsOfNoPrim) {
  constexpr size_t kCount = 5000;
  const auto ball = sphere(6);
  for (size_t i = 0; i < kCount; ++i) b_.add(ball, b_.material({}), testing::moved(double(i % 50)));
  expect_refused(kCount * sizeof(Instance) + kMiB / 2, "", "the hierarchy of instances needs ");
}

}  // namespace
}  // namespace alabaster
