// A scene that memory does not hold as a whole: each part for which it runs out is left out, with one report.
#include "core/scene/memory_lacks.h"

#include <gtest/gtest.h>

#include "core/scene/snapshot_compiler.h"
#include "core/subsurface/body.h"
#include "testenv/support/cages.h"
#include "testenv/support/medium_bodies.h"
#include "testenv/support/memory_texture.h"
#include "testenv/support/scene_builder.h"

namespace alabaster {
namespace {

using testing::SceneBuilder;

constexpr size_t kMiB = size_t(1) << 20;

// The budget counts what the compiler takes, and the interiors of the meshes; BVHs of meshes are on another device.
class MemoryLacksTest : public ::testing::Test {
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
  std::shared_ptr<const SceneSnapshot> compile(bool drawn = true) {
    auto snapshot = compiler_.compile(b_.description, ++number_);
    if (drawn) compiler_.report_faults();
    return snapshot;
  }
  /// So much more than is in use.
  void leave(size_t bytes) { memory_->set_limit(memory_->in_use() + bytes); }

  /// With `bytes` left the scene is compiled without a part, reported once, and whole once there is more.
  std::shared_ptr<const SceneSnapshot> expect_one_lack(size_t bytes, const MemoryLack& lack, const char* code) {
    leave(bytes);
    const auto without = compile();
    EXPECT_TRUE(without && without->top);
    if (!without) return nullptr;
    EXPECT_EQ(without->lacks.size(), 1u);
    EXPECT_TRUE(without->lacks == std::vector{lack});
    EXPECT_EQ(sink_.all().size(), 1u);
    if (sink_.all().empty()) return nullptr;
    const Diagnostic& report = sink_.all()[0];
    EXPECT_EQ(report.code, code);
    EXPECT_EQ(report.severity, changes_picture(lack.kind) ? Severity::error : Severity::warning);
    EXPECT_EQ(report.where, lack.name);
    EXPECT_NE(report.text.find("raise memoryLimit, or "), std::string::npos) << report.text;
    EXPECT_TRUE(compile()->lacks == without->lacks) << "it still does not fit";
    EXPECT_EQ(sink_.all().size(), 1u) << "the same report is not repeated";
    memory_->set_limit(MemoryBudget::kUnlimited);
    whole_ = compile();
    EXPECT_TRUE(whole_->lacks.empty());
    EXPECT_EQ(sink_.all().size(), 1u);
    return without;
  }
  /// Mean and error of a picture from (0, 3, 6).
  static testing::MeanError seen(const std::shared_ptr<const SceneSnapshot>& scene, uint32_t samples,
                                 const Vec3d& target) {
    RenderRequest request;
    request.camera = testing::look_at({0, 3, 6}, target, 12);
    request.width = request.height = 24;
    request.data_window = {0, 0, 24, 24};
    request.settings.samples = samples;
    request.aovs = aov_bit(Aov::color);
    request.scene = scene;
    return testing::film_mean(*testing::render(request), 1);
  }
  static void expect_alike(const testing::MeanError& a, const testing::MeanError& b) {
    EXPECT_NEAR(a.mean, b.mean, 4 * std::hypot(a.standard_error, b.standard_error));
    EXPECT_LT(a.standard_error, 0.05 * a.mean);
  }

  SceneBuilder b_;
  test::RecordingSink sink_;
  std::shared_ptr<MemoryBudget> memory_ = std::make_shared<MemoryBudget>();
  SnapshotCompiler compiler_{make_trace_device(sink_.sink(), memory_), sink_.sink()};
  uint64_t number_ = 0;
  std::shared_ptr<const SceneSnapshot> whole_;
};

// 84 bytes a triangle.
TEST_F(MemoryLacksTest, ABodyIsLeftOut) {
  const auto coarse = sphere(8), fine = sphere(96);
  b_.add(fine, wax(50)).add(fine, wax(50), testing::moved(3)).add(coarse, wax(50), testing::moved(-3));
  b_.add(testing::constant_dome(1, true));
  for (const size_t i : {size_t(0), size_t(1)}) b_.description.instances[i].name = "/fine";
  const auto without = expect_one_lack(kMiB, {LackKind::instance, "/fine", 2}, "instance.memory");
  ASSERT_TRUE(without);
  ASSERT_EQ(without->instances.size(), 1u);
  EXPECT_EQ(without->instances[0].prototype, coarse.get());
  ASSERT_EQ(without->bodies.size(), 1u);
  EXPECT_EQ(without->instances[0].body, without->bodies[0].get());
  EXPECT_EQ(without->bodies[0]->members[0].instance, 0u);
  EXPECT_NE(sink_.all()[0].text.find("the interior of a mesh of "), std::string::npos) << sink_.all()[0].text;
  EXPECT_NE(sink_.all()[0].text.find(": 2 instances of this mesh are left out; the next commit tries again"),
            std::string::npos);
  EXPECT_GT(seen(without, 4, {-3, 0, 0}).mean, 0);
  ASSERT_EQ(whole_->instances.size(), 3u);
  EXPECT_EQ(whole_->bodies.size(), 3u);
}

TEST_F(MemoryLacksTest, ATryThatIsNotDrawnIsNotReported) {
  b_.add(sphere(96), wax(50));
  b_.add(testing::constant_dome(1, true));
  b_.description.instances[0].name = "/fine";
  const auto try_with = [&](size_t bytes, bool drawn) {
    memory_->set_limit(MemoryBudget::kUnlimited);
    compiler_.forget();
    b_.description.instances[0].prototype = sphere(96);  // whose interior is not known
    leave(bytes);
    return compile(drawn)->lacks.size();
  };
  EXPECT_EQ(try_with(kMiB, false), 1u);
  EXPECT_EQ(sink_.all().size(), 0u);
  EXPECT_EQ(try_with(kMiB, true), 1u);
  EXPECT_EQ(sink_.all().size(), 1u);
  EXPECT_EQ(try_with(100 * kMiB, false), 0u);
  EXPECT_EQ(try_with(kMiB, true), 1u);
  EXPECT_EQ(sink_.all().size(), 1u) << "no scene has been drawn with the mesh";
  EXPECT_EQ(try_with(100 * kMiB, true), 0u);
  EXPECT_EQ(try_with(kMiB, true), 1u);
  EXPECT_EQ(sink_.all().size(), 2u);
}

// The distance grid of a mesh takes 10 MB while it is built.
TEST_F(MemoryLacksTest, ABodyWithoutSphereStepsLooksTheSame) {
  b_.add(sphere(24), wax(0.01f)).add(testing::constant_dome(1, false));
  const auto without = expect_one_lack(4 * kMiB, {LackKind::shortcuts, "/test/0", 1}, "subsurface.memory");
  ASSERT_TRUE(without);
  ASSERT_NE(without->instances[0].body, nullptr);
  EXPECT_EQ(without->bodies[0]->members[0].distances, nullptr);
  ASSERT_NE(whole_->bodies[0]->members[0].distances, nullptr);
  expect_alike(seen(without, 16, {0, 0, 0}), seen(whole_, 16, {0, 0, 0}));
}

// Embree takes more than 500 bytes for an instance.
TEST_F(MemoryLacksTest, ASubsurfaceSetIsLeftOutAsAWhole) {
  constexpr size_t kMembers = 3000;
  const auto ball = sphere(6);
  for (size_t i = 0; i < kMembers; ++i) {
    b_.add(ball, wax(50), testing::moved(double(i % 50)));
    b_.description.instances.back().subsurface_set = "set";
    b_.description.instances.back().name = i % 2 ? "/odd" : "/even";
  }
  b_.add(ball, wax(50), testing::moved(-3));
  b_.add(testing::constant_dome(1, true));
  leave(kMembers * sizeof(Instance) + kMiB / 2);
  const auto without = compile();
  ASSERT_TRUE(without && without->top);
  ASSERT_EQ(without->instances.size(), 1u);
  EXPECT_EQ(without->bodies.size(), 1u);
  ASSERT_EQ(without->lacks.size(), 2u);
  EXPECT_EQ(text_of(without->lacks[0]), "/even: memory ran out: 1500 instances are left out with their subsurfaceSet");
  EXPECT_EQ(without->lacks[1].name, "/odd");
  ASSERT_EQ(sink_.all().size(), 1u) << "a set has one report";
  EXPECT_NE(sink_.all()[0].text.find(" needs "), std::string::npos) << sink_.all()[0].text;
  EXPECT_NE(sink_.all()[0].text.find(": 3000 instances are left out with"), std::string::npos) << sink_.all()[0].text;
  memory_->set_limit(MemoryBudget::kUnlimited);
  const auto whole = compile();
  EXPECT_TRUE(whole->lacks.empty());
  EXPECT_EQ(whole->instances.size(), kMembers + 1);
  EXPECT_EQ(whole->bodies.size(), 2u);
}

// Three numbers a texel.
TEST_F(MemoryLacksTest, ALightWithAnImageIsLeftOut) {
  b_.add(sphere(8), b_.material({}));
  LightParameters dome;
  dome.type = LightType::dome;
  dome.name = "/sky";
  dome.texture = std::make_shared<testing::MemoryTexture>(512, std::vector<Rgb>(512 * 256, Rgb(0.5f)));
  b_.add(dome).add(testing::constant_dome(1, true));
  b_.description.lights[1].name = "/constant";
  const auto without = expect_one_lack(kMiB / 2, {LackKind::light, "/sky", 1}, "light.memory");
  ASSERT_TRUE(without);
  EXPECT_EQ(without->lights.size(), 1u);
  EXPECT_EQ(whole_->lights.size(), 2u);
  EXPECT_NE(sink_.all()[0].text.find("make their images smaller"), std::string::npos) << sink_.all()[0].text;
}

TEST_F(MemoryLacksTest, AMeshThatIsNotSampledAsALightGivesTheSameLight) {
  DisneyParameters glow;
  glow.base_color = Rgb(0.0f);
  glow.emission = Rgb(2.0f);
  b_.add(sphere(96), b_.material(glow)).add(b_.prototype(testing::plane_mesh(10)), b_.material({}), testing::moved(0));
  b_.description.instances[1].object_to_world[3][1] = -1.1;
  const auto without = expect_one_lack(kMiB, {LackKind::sampling, "/test/0", 1}, "light.memory");
  ASSERT_TRUE(without);
  EXPECT_EQ(without->lights.size(), 0u);
  ASSERT_EQ(whole_->lights.size(), 1u);
  const Vec3d below(0, -1.1, 2.5);
  expect_alike(seen(without, 64, below), seen(whole_, 64, below));
  const size_t held = memory_->in_use(MemoryUse::lights);
  EXPECT_GT(held, kMiB);
  compiler_.forget();
  whole_ = nullptr;
  EXPECT_EQ(memory_->in_use(MemoryUse::lights), 0u);
}

TEST_F(MemoryLacksTest, AMeshLightCountsOnceHoweverManySnapshotsShareIt) {
  DisneyParameters glow;
  glow.emission = Rgb(2.0f);
  b_.add(sphere(96), b_.material(glow));
  const auto first = compile();
  const size_t held = memory_->in_use(MemoryUse::lights);
  EXPECT_EQ(held, std::get<MeshLight>(first->lights.lights()[0]).memory_bytes());
  const auto second = compile();
  EXPECT_EQ(memory_->in_use(MemoryUse::lights), held);
}

// Nothing can be drawn without the top level.
TEST_F(MemoryLacksTest, ASceneWithoutATopLevelIsRefused) {
  constexpr size_t kCount = 5000;
  const auto ball = sphere(6);
  for (size_t i = 0; i < kCount; ++i) b_.add(ball, b_.material({}), testing::moved(double(i % 50)));
  leave(kCount * sizeof(Instance) + kMiB / 2);
  try {
    compile();
    FAIL() << "it fits";
  } catch (const MemoryRefused& refused) {
    const std::string text = refused.what();
    EXPECT_EQ(text.find("the hierarchy of instances needs "), 0u) << text;
  }
  EXPECT_TRUE(sink_.all().empty()) << "who catches the exception reports it";
  memory_->set_limit(MemoryBudget::kUnlimited);
  EXPECT_TRUE(compile());
}

TEST(MemoryLacks, ThoseThatLeaveThePictureAsItIsAreWarnings) {
  MemoryLacks lacks;
  for (const LackKind kind :
       {LackKind::instance, LackKind::set, LackKind::light, LackKind::sampling, LackKind::shortcuts})
    lacks.add({kind, "/a"}, "no memory");
  std::vector<Severity> severities;
  for (const Diagnostic& report : lacks.reports()) severities.push_back(report.severity);
  constexpr Severity kError = Severity::error, kWarning = Severity::warning;
  EXPECT_EQ(severities, (std::vector{kError, kError, kError, kWarning, kWarning}));
}

}  // namespace
}  // namespace alabaster
