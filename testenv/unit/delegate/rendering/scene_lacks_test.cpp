#include "delegate/rendering/scene_lacks.h"

#include <gtest/gtest.h>

namespace alabaster::hd::rendering {
namespace {

/// A scene that draws the prims `drawn`. Prims `faulty` have faults for want of memory.
SceneLacks lacks(const std::vector<MemoryLack>& of_snapshot, const std::vector<std::string>& faulty = {},
                 const std::vector<std::string>& drawn = {}) {
  SceneDescription scene;
  for (const std::string& name : drawn) scene.instances.emplace_back().name = name;
  prims::SceneFaults faults;
  faults[Path("/texture")] = {true, "a fault of the input"};
  for (const std::string& name : faulty) faults[Path(name)] = {false, "memory ran out"};
  SceneSnapshot snapshot;
  snapshot.lacks = of_snapshot;
  SceneLacks made;
  made.add(faults, scene);
  made.add(snapshot);
  return made;
}

const SceneLacks kNone = lacks({});

void expect_better(const SceneLacks& a, const SceneLacks& b) {
  EXPECT_TRUE(a.is_better_than(b));
  EXPECT_TRUE(a.shows_all_of(b));
  EXPECT_FALSE(b.is_better_than(a));
}
void expect_neither_is_better(const SceneLacks& a, const SceneLacks& b) {
  EXPECT_FALSE(a.is_better_than(b));
  EXPECT_FALSE(b.is_better_than(a));
}

TEST(SceneLacks, ASceneIsBetterThatLosesNothingAndHasMore) {
  const SceneLacks one = lacks({{LackKind::instance, "/a", 1}}), two = lacks({{LackKind::set, "/a", 2}}),
                   other = lacks({{LackKind::light, "/b", 1}}),
                   both = lacks({{LackKind::instance, "/a", 1}, {LackKind::light, "/b", 1}});
  expect_better(kNone, one);
  expect_better(one, two);
  expect_better(one, both);
  expect_better(other, both);
  expect_neither_is_better(one, other);
  EXPECT_FALSE(one.shows_all_of(other));
  expect_neither_is_better(one, one);
  expect_neither_is_better(kNone, kNone);
  EXPECT_TRUE(kNone.empty());
  for (const SceneLacks& lacking : {one, two, other}) EXPECT_FALSE(lacking.empty());
}

TEST(SceneLacks, AMeshThatIsRefusedLacksAllThatItsInstancesMayLack) {
  const SceneLacks mesh = lacks({}, {"/a"});
  expect_better(kNone, mesh);
  expect_better(lacks({{LackKind::instance, "/a", 3}}), mesh);
  expect_better(lacks({}, {"/a"}, {"/a"}), mesh);  // drawn without deformation
  expect_better(mesh, lacks({}, {"/a", "/b"}));
  expect_neither_is_better(mesh, lacks({}, {"/b"}));
  expect_neither_is_better(lacks({}, {"/a"}, {"/a"}), lacks({{LackKind::instance, "/a", 1}}));
}

TEST(SceneLacks, ThePictureCountsBeforeItsCost) {
  const SceneLacks part = lacks({{LackKind::instance, "/a", 1}}), slow = lacks({{LackKind::shortcuts, "/b", 1}}),
                   noisy = lacks({{LackKind::sampling, "/b", 1}}),
                   slower = lacks({{LackKind::shortcuts, "/b", 1}, {LackKind::shortcuts, "/c", 1}});
  expect_better(slow, part);
  expect_better(kNone, slow);
  expect_better(slow, slower);
  expect_neither_is_better(slow, noisy);
  EXPECT_TRUE(slow.shows_all_of(noisy)) << "the same picture";
}

}  // namespace
}  // namespace alabaster::hd::rendering
