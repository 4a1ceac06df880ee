// Any sequence of edits leaves the scene and the picture of a scene that is made at once, and of its archive.
#include <gtest/gtest.h>

#include <random>
#include <regex>

#include "delegate/archive/archive.h"
#include "delegate/host/scene_fields.h"
#include "testenv/support/gltf_testing.h"
#include "testenv/support/stage.h"

namespace alabaster::hd {
namespace {

using host::Fields;

/// What a host has asked for: the fields of each prim by name, without those that were taken back.
struct Asked {
  Token kind;
  std::map<std::string, Value> fields;
  void set(const Fields& given) {
    for (const auto& [name, value] : given) {
      if (name == "transform") fields.erase("transform:samples");
      fields[name] = value;
      if (value.empty()) fields.erase(name);
    }
  }
};

class RandomHost {
 public:
  explicit RandomHost(unsigned seed) : random_(seed) {}

  /// A step of the host: mostly an edit of some fields.
  void step(host::RetainedSceneDelegate* scene) {
    const Path path = pick<Path>({"/body", "/lid", "/many", "/wax", "/key"});
    const auto found = asked_.find(path);
    if (found == asked_.end() || chance(0.1)) {
      Asked made{kind_of(path), {}};
      Fields fields = base_of(path);
      for (const auto& field : some_fields(path)) fields.push_back(field);
      made.set(fields);
      ASSERT_EQ(SetPrim(scene, path, made.kind, fields).fault, "");
      asked_[path] = std::move(made);
    } else if (chance(0.1)) {
      ASSERT_TRUE(scene->Remove(path));
      asked_.erase(found);
    } else {
      const Fields fields = some_fields(path);
      ASSERT_EQ(EditPrim(scene, path, fields).fault, "");
      found->second.set(fields);
    }
  }
  /// The same scene, its prims in any order.
  void make(host::RetainedSceneDelegate* scene) {
    std::vector<Path> paths;
    for (const auto& prim : asked_) paths.push_back(prim.first);
    std::shuffle(paths.begin(), paths.end(), random_);
    for (const Path& path : paths) {
      Fields fields(asked_[path].fields.begin(), asked_[path].fields.end());
      std::shuffle(fields.begin(), fields.end(), random_);
      ASSERT_EQ(SetPrim(scene, path, asked_[path].kind, fields).fault, "") << path.str();
    }
  }

 private:
  bool chance(double share) { return std::uniform_real_distribution<>(0, 1)(random_) < share; }
  float number(float low, float high) { return std::uniform_real_distribution<float>(low, high)(random_); }
  template <class T>
  T pick(std::initializer_list<T> all) {
    return *(all.begin() + std::uniform_int_distribution<long>(0, long(all.size()) - 1)(random_));
  }
  Value color() { return Vec3f(number(0, 1), number(0, 1), number(0, 1)); }
  Matrix4d place() { return Matrix4d().setTranslation(Vec3d(number(-1, 1), number(-1, 1), number(-1, 1))); }

  Token kind_of(const Path& path) {
    if (path == Path("/key")) return pick<Token>({"rectLight", "sphereLight"});
    return path == Path("/many") ? "instancer" : path == Path("/wax") ? "material" : "mesh";
  }
  Fields base_of(const Path& path) {
    if (path == Path("/wax")) return {{"surface.type", Token("AlabasterDisney")}};
    if (path == Path("/many"))
      return {{"primvars:hydra:instanceTranslations", Array<Vec3f>{{-1, 0, 0}, {1, 0, 0}}},
              {"prototypes:/lid", Array<int32_t>{0, 1}}};
    if (path == Path("/key")) return {{"transform", Matrix4d().setTranslation(Vec3d(0, 0, 3))}};
    const Cage cage = test::cube_cage();
    return {{"faceVertexCounts", Array<int32_t>(cage.face_vertex_counts)},
            {"faceVertexIndices", Array<int32_t>(cage.face_vertex_indices)},
            {"primvars:points", Array<Vec3f>(cage.points)}};
  }
  Fields some_fields(const Path& path) {
    Fields all = fields_of(path);
    std::shuffle(all.begin(), all.end(), random_);
    all.resize(size_t(pick({1, 2, 3})));
    for (auto& [name, value] : all)
      if (chance(0.2)) value = {};  // the default
    // Samples are set after what they belong to.
    std::stable_partition(all.begin(), all.end(), [](const auto& field) { return !field.first.ends_with(":samples"); });
    return all;
  }
  Fields fields_of(const Path& path) {
    const Value near = Array<Token>{"near"}, one = Array<int32_t>{pick({0, 1})};
    const Value moving = std::make_shared<const TimeSamples<Value>>(TimeSamples<Value>{{0, 1}, {place(), place()}});
    if (path == Path("/wax"))
      return {{"surface.roughness", number(0, 1)},
              {"surface.baseColor", color()},
              {"surface.scatterDistance", color()},
              {"surface.emission", color()},
              {"surface.specularTint", number(0, 1)}};
    if (path == Path("/many"))
      return {
          {"transform", place()}, {"transform:samples", moving}, {"categories:near", one}, {"prototypes:/body", one}};
    if (path == Path("/key"))
      return {{"intensity", number(0, 9)}, {"color", color()},       {"transform", place()},
              {"radius", number(0.1f, 1)}, {"visible", chance(0.5)}, {"lightLink", Token("near")}};
    return {{"scheme", pick<Token>({"catmullClark", "bilinear"})},
            {"refineLevel", pick({0, 1, 2})},
            {"orientation", Token("leftHanded")},
            {"holeIndices", one},
            {"invisibleFaces", one},
            {"interpolateBoundary", Token("none")},
            {"cullStyle", pick<Token>({"back", "front"})},
            {"transform", place()},
            {"transform:samples", moving},
            {"visible", chance(0.5)},
            {"doubleSided", chance(0.5)},
            {"material", Path("/wax")},
            {"instancer", Path("/many")},
            {"renderTag", pick<Token>({"render", "proxy"})},
            {"categories", near},
            {"subsets:part:faces", Array<int32_t>{pick({0, 1, 2}), pick({3, 4, 5})}},
            {"subsurfaceSet", Token("set")},
            {"primvars:displayColor", color()},
            {"holdout", chance(0.5)}};
  }

  std::mt19937 random_;
  std::map<Path, Asked> asked_;
};

struct Rendered {
  Rendered() : stage({{"samples", int64_t(2)}, {"threads", 2}}) {
    stage.add_basic_scene();
    buffer = stage.add_buffer("/b", 16, 16, Format::float32vec4);
    stage.index->SyncAll();
    pass = stage.delegate->CreateRenderPass();
    state = Stage::state_for(16, 16, "color", buffer);
  }
  ~Rendered() { pass.reset(); }
  std::vector<float> picture() {
    stage.index->SyncAll();
    EXPECT_TRUE(Stage::finish(*pass, state));
    return Stage::pixels<float>(buffer);
  }

  /// Without the numbers of prims, which are those of the order in which they came.
  std::string dump() { return std::regex_replace(stage.dump(), std::regex(" prim [0-9]+"), ""); }

  Stage stage;
  RenderBuffer* buffer = nullptr;
  std::unique_ptr<RenderPass> pass;
  RenderPassState state;
};

class AnyEdits : public ::testing::TestWithParam<unsigned> {};

// promise: embedding.edit.newer
TEST_P(AnyEdits, LeaveTheSceneThatIsMadeAtOnce) {
  RandomHost host(GetParam());
  Rendered edited, fresh;
  for (int step = 0; step < 150; ++step) {
    ASSERT_NO_FATAL_FAILURE(host.step(&edited.stage.scene)) << step;
    if (step % 3 > 0) continue;
    edited.stage.index->SyncAll();
    if (step % 2 > 0) edited.pass->Execute(edited.state);
  }
  ASSERT_NO_FATAL_FAILURE(host.make(&fresh.stage.scene));
  EXPECT_TRUE(edited.stage.scene.GetPrims() == fresh.stage.scene.GetPrims());
  EXPECT_EQ(edited.picture(), fresh.picture());
  EXPECT_EQ(edited.dump(), fresh.dump());

  host::RetainedSceneDelegate read;
  const gltf::testing::TemporaryFolder folder;
  const std::string file = folder.path() + "/a.alab";
  ASSERT_EQ(archive::WriteArchive(file, edited.stage.scene.GetPrims()), "");
  ASSERT_TRUE(archive::ReadArchive(file, &read, {}).ok);
  host::Prims given = edited.stage.scene.GetPrims();
  given.erase("/b");  // the buffer
  EXPECT_TRUE(given == read.GetPrims());
}
INSTANTIATE_TEST_SUITE_P(Seeds, AnyEdits, ::testing::Range(0u, 12u));

}  // namespace
}  // namespace alabaster::hd
