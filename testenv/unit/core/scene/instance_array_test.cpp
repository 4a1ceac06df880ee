#include "core/scene/instance_array.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "core/scene/snapshot_compiler.h"
#include "testenv/support/cages.h"
#include "testenv/support/scene_builder.h"

namespace alabaster {
namespace {

using testing::SceneBuilder;

class ListedPlaces final : public InstancePlaces {
 public:
  explicit ListedPlaces(std::vector<std::optional<Matrix4d>> places) : places_(std::move(places)) {}
  size_t size() const override { return places_.size(); }
  std::optional<Matrix4d> at(size_t number) const override { return places_[number]; }
  bool stand_alike(const InstancePlaces& other, size_t begin, size_t end) const override {
    const auto& held = static_cast<const ListedPlaces&>(other).places_;
    return std::equal(places_.begin() + std::ptrdiff_t(begin), places_.begin() + std::ptrdiff_t(end),
                      held.begin() + std::ptrdiff_t(begin));
  }

 private:
  const std::vector<std::optional<Matrix4d>> places_;
};

Matrix4d placed(double x, double y, double z, double scale = 0.05) {
  return Matrix4d().setScale(scale) * Matrix4d().setTranslation(Vec3d(x, y, z));
}

// A cloud of spheres in a cube of side 2, above a floor, under a dome.
class InstanceArrayTest : public ::testing::Test {
 protected:
  static constexpr size_t kCount = 5000;

  InstanceArrayTest() {
    std::mt19937 random(11);
    std::uniform_real_distribution<double> number(-1, 1);
    for (size_t i = 0; i < kCount; ++i)
      places_.emplace_back(placed(number(random), number(random), number(random), 0.02));
    DisneyParameters matte;
    matte.base_color = {0.8f, 0.5f, 0.3f};
    const auto sphere = b_.prototype(testing::sphere_mesh(1, 6, true));
    InstanceDescription look{sphere, Matrix4d(), {}, {b_.material(matte)}, 3, 0, "/leaf"};
    b_.description.arrays.push_back({look, nullptr});
    b_.add(b_.prototype(testing::plane_mesh(8)), b_.material({}), Matrix4d().setTranslation(Vec3d(0, -1.2, 0)));
    b_.add(testing::constant_dome(1, true));
  }

  std::shared_ptr<const SceneSnapshot> compile() {
    b_.description.arrays[0].places = std::make_shared<ListedPlaces>(places_);
    return compiler_.compile(b_.description, ++number_);
  }
  void expect_refused(const std::string& prim, const std::string& text) {
    try {
      compile();
      ADD_FAILURE() << "it fits";
    } catch (const MemoryRefused& refused) {
      EXPECT_EQ(refused.prim(), prim);
      EXPECT_EQ(std::string(refused.what()).find(text), 0u) << refused.what();
    }
  }
  // The same as instances that stand alone.
  SceneDescription flat() const {
    SceneDescription flat = b_.description;
    flat.arrays.clear();
    for (size_t i = 0; i < places_.size(); ++i)
      if (auto one = b_.description.arrays[0].instance(i)) flat.instances.push_back(std::move(*one));
    return flat;
  }
  static RenderRequest request_of(const std::shared_ptr<const SceneSnapshot>& scene, Aov aov) {
    RenderRequest request;
    request.camera = testing::look_at({0.4, 1, 4}, {0, 0, 0}, 45);
    request.width = request.height = 32;
    request.data_window = {0, 0, 32, 32};
    request.settings.samples = 4;
    request.settings.max_depth = 4;  // longer paths part, once they meet another triangle
    request.aovs = aov_bit(aov);
    request.scene = scene;
    return request;
  }
  static std::vector<float> picture(const std::shared_ptr<const SceneSnapshot>& scene, Aov aov) {
    return testing::render(request_of(scene, aov))->resolve_float(aov);
  }
  static std::shared_ptr<const Film> film(const std::shared_ptr<const SceneSnapshot>& scene, SubsurfaceMode mode) {
    RenderRequest request = request_of(scene, Aov::color);
    request.settings.subsurface = mode;
    return testing::render(request);
  }
  static size_t shared_cells(const SceneSnapshot& a, const SceneSnapshot& b) {
    const auto &x = a.arrays[0].placed->traced.cells, &y = b.arrays[0].placed->traced.cells;
    size_t shared = 0;
    for (const auto& cell : x) shared += std::find(y.begin(), y.end(), cell) != y.end();
    return shared;
  }

  SceneBuilder b_;
  test::RecordingSink sink_;
  std::shared_ptr<MemoryBudget> memory_ = std::make_shared<MemoryBudget>();
  std::shared_ptr<TraceDevice> device_ = make_trace_device(sink_.sink(), memory_);
  SnapshotCompiler compiler_{device_, sink_.sink()};
  uint64_t number_ = 0;
  std::vector<std::optional<Matrix4d>> places_;
};

// The origins of the two differ by rounding, and so do directions in the last bits.
TEST_F(InstanceArrayTest, LooksAsItsInstancesDoAlone) {
  const auto array = compile();
  const auto alone = compile_snapshot(flat(), 1, device_, sink_.sink());
  ASSERT_TRUE(array && alone);
  EXPECT_EQ(array->instance_count(), alone->instance_count());
  const std::vector<float> a = picture(array, Aov::color), b = picture(alone, Aov::color);
  double sum_a = 0, sum_b = 0;
  size_t different = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    sum_a += double(a[i]), sum_b += double(b[i]);
    different += std::abs(a[i] - b[i]) > 1e-3f * b[i];
  }
  EXPECT_LT(different, a.size() / 16) << "a path that meets another triangle is another path";
  EXPECT_NEAR(sum_a, sum_b, 1e-3 * sum_b);
  const std::vector<float> depth = picture(array, Aov::camera_depth), depth_alone = picture(alone, Aov::camera_depth);
  for (size_t i = 0; i < depth.size(); ++i) EXPECT_NEAR(depth[i], depth_alone[i], 1e-4f * depth_alone[i]) << i;
}

// Bodies of an array are one body that stands in many places.
TEST_F(InstanceArrayTest, ScattersAsItsInstancesDoAlone) {
  DisneyParameters wax;
  wax.base_color = {0.8f, 0.6f, 0.5f};
  wax.scatter_distance = Rgb(0.01f);
  b_.description.arrays[0].look.materials = {b_.material(wax)};
  const auto array = compile();
  EXPECT_EQ(array->bodies.size(), 1u);
  EXPECT_TRUE(array->features.subsurface);
  const auto alone = compile_snapshot(flat(), 1, device_, sink_.sink());
  for (const SubsurfaceMode mode : {SubsurfaceMode::walk, SubsurfaceMode::diffusion}) {
    const auto together = testing::film_mean(*film(array, mode), 1), apart = testing::film_mean(*film(alone, mode), 1);
    EXPECT_NEAR(together.mean, apart.mean, 3e-3 * apart.mean) << int(mode);
  }
  // The places are measured again for a material that begins to scatter.
  b_.description.arrays[0].look.materials = {b_.material({})};
  const auto matte = compile();
  EXPECT_TRUE(matte->bodies.empty());
  b_.description.arrays[0].look.materials = {b_.material(wax)};
  EXPECT_NEAR(compile()->bodies.front()->members.front().least_stretch, 0.02f, 1e-6f);
}

// Bodies that light goes through are told apart by their index, and faces that rays pass by their instance's place.
TEST_F(InstanceArrayTest, GlassVeilsAndSingleSidesLookAsAlone) {
  DisneyParameters glass, veil;
  glass.spec_trans = 1;
  glass.roughness = 0;
  glass.ior = 1.3f;
  veil.opacity = 0.4f;
  for (auto& place : places_) (*place)[1][1] *= -1;  // mirrored
  const auto compare = [&](const char* what) {
    const auto array = compile();
    const auto alone = compile_snapshot(flat(), 1, device_, sink_.sink());
    ASSERT_EQ(array->arrays.size(), 1u) << what;
    EXPECT_EQ(array->features.see_through, alone->features.see_through) << what;
    for (const Vec3f& p : {alone->clear_bodies.lower, alone->clear_bodies.upper})
      EXPECT_TRUE(alone->clear_bodies.empty() || array->clear_bodies.contains(p + Vec3f(alone->origin - array->origin)))
          << what;
    const auto together = testing::film_mean(*film(array, SubsurfaceMode::walk), 1);
    const auto apart = testing::film_mean(*film(alone, SubsurfaceMode::walk), 1);
    EXPECT_NEAR(together.mean, apart.mean, 3e-3 * apart.mean) << what;
  };
  InstanceDescription& look = b_.description.arrays[0].look;
  look.materials = {b_.material(glass)};
  compare("glass");
  look.materials = {b_.material(veil)};
  compare("veil");
  look.materials = {b_.material({})};
  look.options.camera_cull = CameraCull::front;
  compare("culled");
}

TEST_F(InstanceArrayTest, IsTakenApartWhereInstancesMustBeKnownOneByOne) {
  DisneyParameters wax, glow;
  wax.scatter_distance = Rgb(0.1f);
  glow.emission = Rgb(1.0f);
  InstanceDescription& look = b_.description.arrays[0].look;
  places_.resize(20);
  EXPECT_EQ(compile()->arrays.size(), 1u);
  look.materials = {b_.material(glow)};
  EXPECT_EQ(compile()->instances.size(), 21u);
  look.materials = {b_.material(wax)};
  EXPECT_EQ(compile()->arrays.size(), 1u);
  look.subsurface_set = "all";
  const auto set = compile();
  EXPECT_EQ(set->instances.size(), 21u);
  EXPECT_EQ(set->bodies.size(), 1u);
  look.subsurface_set.clear();
  look.prototype = b_.prototype(testing::plane_mesh(1));
  EXPECT_EQ(compile()->instances.size(), 21u) << "open";
  look.materials = {b_.material({})};
  EXPECT_EQ(compile()->arrays.size(), 1u);
}

TEST_F(InstanceArrayTest, AnEditBuildsTheCellsThatItTouchesAndLooksAsFresh) {
  const auto first = compile();
  const size_t cells = first->arrays[0].placed->traced.cells.size();
  ASSERT_EQ(cells, 5u);
  places_[100] = placed(0, 0.9, 0.5, 0.3);
  places_[101] = std::nullopt;
  const auto second = compile();
  EXPECT_NE(second->top, first->top);
  EXPECT_EQ(second->origin, first->origin);
  EXPECT_GE(shared_cells(*second, *first), cells - 2);
  EXPECT_LT(shared_cells(*second, *first), cells);
  const auto fresh = SnapshotCompiler(device_, sink_.sink()).compile(b_.description, 1);
  EXPECT_EQ(picture(second, Aov::color), picture(fresh, Aov::color));
  EXPECT_EQ(picture(second, Aov::instance_id), picture(fresh, Aov::instance_id));
  const auto again = compile();
  EXPECT_EQ(again->top, second->top) << "nothing has moved";
}

TEST_F(InstanceArrayTest, ArrayGrowsAndShrinksAtItsEnd) {
  auto last = compile();
  const size_t cells = last->arrays[0].placed->traced.cells.size();
  const auto expect_as_fresh = [&](const char* what) {
    const auto now = compile();
    ASSERT_EQ(now->arrays[0].placed->size(), places_.size()) << what;
    EXPECT_GE(shared_cells(*now, *last), cells - 2) << what;
    const auto fresh = SnapshotCompiler(device_, sink_.sink()).compile(b_.description, 1);
    EXPECT_EQ(picture(now, Aov::color), picture(fresh, Aov::color)) << what;
    EXPECT_EQ(picture(now, Aov::instance_id), picture(fresh, Aov::instance_id)) << what;
    last = now;
  };
  const auto taken = places_.back();
  places_.pop_back();
  expect_as_fresh("one fewer");
  places_.push_back(placed(0, 0.9, 0.5, 0.3));
  expect_as_fresh("another in its place");
  for (int i = 0; i < 300; ++i) places_.push_back(placed(0.9 - 0.006 * i, 1, 0.5, 0.02));
  expect_as_fresh("more than the last cell has room for");
  EXPECT_EQ(last->arrays[0].placed->traced.cells.size(), cells + 1);
  places_.resize(kCount - 1);
  places_.push_back(taken);
  expect_as_fresh("an empty cell is left");
}

TEST_F(InstanceArrayTest, SaysHowManyItLeavesOut) {
  places_[1] = Matrix4d().setScale(0.0);
  places_[2] = placed(0, 0, 0, std::numeric_limits<double>::quiet_NaN());
  places_[3] = placed(3e17, 0, 0);
  places_[4] = placed(0, 0, 0, 1e-19);
  const auto scene = compile();
  ASSERT_TRUE(scene);
  std::vector<Diagnostic> said;
  for (const Diagnostic& d : sink_.all())
    if (d.code == "instance.transform") said.push_back(d);
  ASSERT_EQ(said.size(), 2u);
  EXPECT_EQ(said[0].text.substr(0, 9), "2 of 5000") << said[0].text;
  EXPECT_EQ(said[0].severity, Severity::warning);
  EXPECT_EQ(said[1].text.substr(0, 9), "2 of 5000") << said[1].text;
  EXPECT_EQ(said[1].severity, Severity::error);
  EXPECT_EQ(scene->left_out, std::vector<std::string>{"/leaf"});
  picture(scene, Aov::color);
}

TEST_F(InstanceArrayTest, CountsThoseThatStandTooFarForTheirSize) {
  for (size_t i = 0; i < 3; ++i) places_[i] = placed(i == 0, i == 1, i == 2, 1e-7);
  ASSERT_TRUE(compile());
  ASSERT_EQ(sink_.all().size(), 1u);
  EXPECT_EQ(sink_.all()[0].code, "scene.far");
  EXPECT_EQ(sink_.all()[0].text.substr(0, 5), "3 of ") << "not all of their block";
}

// The origin lies beside the small ones, and stays there.
TEST_F(InstanceArrayTest, AStrayGiantDoesNotTakeThePrecisionFromTheOthers) {
  for (auto& place : places_) (*place)[3][0] += 2e5;
  const auto alone = [&] {
    b_.description.arrays[0].places = std::make_shared<ListedPlaces>(places_);
    SceneDescription flat = this->flat();
    flat.instances.push_back(b_.description.arrays[0].look);
    flat.instances.back().object_to_world = placed(1e7, 0, 0, 1e3);
    return compile_snapshot(flat, 1, device_, sink_.sink());
  }();
  b_.description.instances.push_back(b_.description.arrays[0].look);
  b_.description.instances.back().object_to_world = placed(1e7, 0, 0, 1e3);
  EXPECT_LT(length(compile()->origin - Vec3d(2e5, 0, 0)), 2);
  EXPECT_LT(length(alone->origin - Vec3d(2e5, 0, 0)), 2);
}

// Where some are lost wherever the origin is, the choice still does not know which cells there were.
TEST_F(InstanceArrayTest, TheOriginDoesNotDependOnEdits) {
  for (auto& place : places_)
    for (int i = 0; i < 3; ++i) (*place)[i][i] = 1e-8;
  compile();
  for (size_t i = 0; i < kCount / 8; ++i) places_[i] = places_[kCount - 1 - i];
  const auto edited = compile();
  const auto fresh = SnapshotCompiler(device_, sink_.sink()).compile(b_.description, 1);
  EXPECT_EQ(edited->origin, fresh->origin);
  EXPECT_EQ(picture(edited, Aov::color), picture(fresh, Aov::color));
}

TEST_F(InstanceArrayTest, AnArrayThatMemoryDoesNotHoldIsRefusedByName) {
  memory_->set_limit(20 * kCount);  // less than one cell
  expect_refused("/leaf", "an array of 5000 instances");
  memory_->set_limit(MemoryBudget::kUnlimited);
  EXPECT_EQ(compile()->arrays.size(), 1u);
}

// The shells of a mesh decide if its instances are an array.
TEST_F(InstanceArrayTest, AnArrayOfBodiesThatMemoryDoesNotHoldIsRefusedByName) {
  auto fine = std::make_shared<MeshPrototype>();
  fine->mesh = testing::sphere_mesh(1, 64, true);
  fine->object = b_.prototype(fine->mesh)->object;
  fine->interior.count_in(memory_);
  DisneyParameters wax;
  wax.scatter_distance = Rgb(10.0f);
  compile();
  const InstanceDescription look{fine, Matrix4d(), {}, {b_.material(wax)}, 4, 0, "/grains"};
  const std::vector<std::optional<Matrix4d>> places(places_.begin(), places_.begin() + 100);
  b_.description.arrays.push_back({look, std::make_shared<ListedPlaces>(places)});
  memory_->set_limit(memory_->in_use() + (size_t(1) << 20));  // of 84 bytes for each of 16128 triangles
  expect_refused("/grains", "the interior of a mesh of 16128 triangles");
  memory_->set_limit(MemoryBudget::kUnlimited);
  EXPECT_EQ(compile()->arrays.size(), 2u);
}

TEST_F(InstanceArrayTest, ACancelledBuildThrows) {
  b_.description.arrays[0].places = std::make_shared<ListedPlaces>(places_);
  const std::atomic<bool> cancelled{true};
  EXPECT_THROW(compiler_.compile(b_.description, 1, CancelToken(&cancelled)), BuildCancelled);
  EXPECT_THROW(plan_array(b_.description.arrays[0], nullptr, memory_, CancelToken(&cancelled)), BuildCancelled);
}

}  // namespace
}  // namespace alabaster
