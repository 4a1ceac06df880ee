// Any sequence of edits, through C++ or C, leaves the scene and the picture of a scene that is made at once, and of its
// archive.
#include "delegate/archive/archive.h"
#include "testenv/support/gltf_testing.h"
#include "testenv/unit/delegate/doors/doors.h"
#include "testenv/unit/delegate/doors/random_scene.h"

namespace alabaster::hd::doors {
namespace {

/// What a host has asked for: the fields of each prim by name, without those that were taken back.
struct Asked {
  Token kind;
  std::map<std::string, Value> fields;
  void set(const Fields& given) {
    for (const auto& [name, value] : given) {
      fields.erase(name + ":samples");
      fields[name] = value;
      if (value.empty()) take_back(name);
    }
  }

 private:
  /// A primvar or a subset goes with all that belongs to it.
  void take_back(const std::string& name) {
    const std::string all = name.ends_with(":faces") ? name.substr(0, name.rfind(':') + 1) : name + ":";
    fields.erase(name);
    std::erase_if(fields, [&](const auto& field) { return field.first.starts_with(all); });
  }
};

class RandomHost {
 public:
  explicit RandomHost(unsigned seed) : random_(seed) {}

  /// A step of the host: mostly an edit of some fields. What one door refuses, all refuse, and nothing is changed.
  void step(const std::vector<Door*>& doors) {
    const Path path = random_.pick(kPaths);
    const auto found = asked_.find(path);
    const bool is_set = found == asked_.end() || random_.chance(0.1);
    if (!is_set && path != Path("/camera") && random_.chance(0.1)) {
      for (Door* door : doors) door->remove(path);
      asked_.erase(found);
      return;
    }
    Fields fields = is_set ? RandomScene::base_of(path) : Fields();
    for (auto& field : random_.some_fields(path)) fields.push_back(std::move(field));
    const Token kind = random_.kind_of(path);
    std::vector<std::string> faults;
    for (Door* door : doors) faults.push_back(is_set ? door->set(path, kind, fields) : door->edit(path, fields));
    for (std::string& fault : faults) {
      const std::string prefix = path.str() + ": ";  // the C interface names the prim
      if (fault.starts_with(prefix)) fault.erase(0, prefix.size());
      EXPECT_EQ(fault, faults[0]);
    }
    if (!faults[0].empty()) return;
    if (is_set) asked_[path] = {kind, {}};
    asked_[path].set(fields);
  }
  /// The same scene, its prims and their fields in any order.
  void make(Door* door) {
    std::vector<Path> paths;
    for (const auto& prim : asked_) paths.push_back(prim.first);
    random_.shuffle(&paths);
    for (const Path& path : paths) {
      Fields fields(asked_[path].fields.begin(), asked_[path].fields.end());
      random_.shuffle(&fields);
      ASSERT_EQ(door->set(path, asked_[path].kind, fields), "") << path.str();
    }
  }

 private:
  RandomScene random_;
  std::map<Path, Asked> asked_;
};

class AnyEdits : public ::testing::TestWithParam<unsigned> {};

// promise: embedding.edit.newer
TEST_P(AnyEdits, LeaveTheSceneThatIsMadeAtOnce) {
  RandomHost host(GetParam());
  CppDoor edited, fresh;
  CDoor c;
  for (int step = 0; step < 150; ++step) {
    ASSERT_NO_FATAL_FAILURE(host.step({&edited, &c})) << step;
    if (step % 6 == 3) edited.draw(), c.draw();
    if (step % 6 == 0) edited.stage.index->SyncAll();
  }
  ASSERT_NO_FATAL_FAILURE(host.make(&fresh));
  EXPECT_TRUE(edited.prims() == fresh.prims());
  const std::vector<float> picture = fresh.picture();
  const std::string dump = fresh.dump();
  EXPECT_EQ(edited.picture(), picture);
  EXPECT_EQ(c.picture(), picture);
  EXPECT_EQ(edited.dump(), dump);
  EXPECT_EQ(c.dump(), dump);

  const gltf::testing::TemporaryFolder folder;
  const auto archived = [&](const char* name, const host::Prims& prims) {
    EXPECT_EQ(archive::WriteArchive(folder.path() + name, prims), "");
    host::RetainedSceneDelegate read;
    EXPECT_TRUE(archive::ReadArchive(folder.path() + name, &read, {}).ok);
    EXPECT_TRUE(read.GetPrims() == prims) << name;
    return gltf::testing::read_text(folder.path() + name);
  };
  EXPECT_EQ(archived("/edited.alab", edited.prims()), archived("/fresh.alab", fresh.prims()));
}
INSTANTIATE_TEST_SUITE_P(Seeds, AnyEdits, ::testing::Range(0u, 8u));

}  // namespace
}  // namespace alabaster::hd::doors
