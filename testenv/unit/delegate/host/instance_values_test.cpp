// Edits of parts of an instancer's arrays, while others still read the arrays of before.
#include <gtest/gtest.h>

#include <random>

#include "delegate/host/retained_scene_delegate.h"
#include "testenv/unit/delegate/host/fake_delegate.h"

namespace alabaster::hd::host {
namespace {

constexpr const char* kPlaces = "hydra:instanceTranslations";

std::vector<Vec3f> in_a_row(size_t count) {
  std::vector<Vec3f> places;
  for (size_t i = 0; i < count; ++i) places.emplace_back(static_cast<float>(i), 0.0f, 0.0f);
  return places;
}

struct Leaves {
  RetainedSceneDelegate scene;

  explicit Leaves(const std::vector<Vec3f>& places) { set(places); }
  void set(const std::vector<Vec3f>& places) {
    InstancerDescription leaves;
    leaves.primvars[kPlaces] = Array<Vec3f>(places);
    leaves.primvars["hydra:instanceRotations"] = Array<Quatf>(std::vector<Quatf>(places.size()));
    scene.SetInstancer("/leaves", leaves);
  }
  Array<Vec3f> now() { return *scene.GetInstancers().at("/leaves").primvars.at(kPlaces).get<Array<Vec3f>>(); }
  bool move(size_t first, std::vector<Vec3f> places) {
    return scene.SetInstanceValues("/leaves", kPlaces, first, Array<Vec3f>(std::move(places)));
  }
};

bool same(const Array<Vec3f>& a, const std::vector<Vec3f>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end());
}

TEST(InstanceValues, LastEditWinsAndOtherInstancesAreUnchanged) {
  std::mt19937 random(3);
  std::vector<Vec3f> expected = in_a_row(50);
  Leaves leaves(expected);
  std::vector<std::pair<Array<Vec3f>, std::vector<Vec3f>>> held;
  for (int edit = 0; edit < 2000; ++edit) {
    const size_t count = random() % 4, first = random() % (expected.size() - count + 1);
    std::vector<Vec3f> places;
    for (size_t i = 0; i < count; ++i) places.emplace_back(static_cast<float>(edit), static_cast<float>(i), 1.0f);
    std::copy(places.begin(), places.end(), expected.begin() + static_cast<std::ptrdiff_t>(first));
    ASSERT_TRUE(leaves.move(first, places));
    ASSERT_TRUE(same(leaves.now(), expected)) << edit;
    // Some are read for a while, a few of them for longer than the edits are remembered.
    if (random() % 3 == 0) held.emplace_back(leaves.now(), expected);
    if (held.size() > 5) held.erase(held.begin() + static_cast<std::ptrdiff_t>(random() % held.size()));
    for (const auto& [array, values] : held) ASSERT_TRUE(same(array, values)) << edit;
    if (edit % 500 == 499) leaves.set(expected = in_a_row(50 + size_t(edit) / 100));
  }
}

TEST(InstanceValues, PrimvarThatTheArrayLacksIsRefused) {
  Leaves leaves(in_a_row(3));
  const Array<Vec3f> one{Vec3f(7)}, two{Vec3f(7), Vec3f(8)};
  EXPECT_FALSE(leaves.scene.SetInstanceValues("/missing", kPlaces, 0, one));
  EXPECT_FALSE(leaves.scene.SetInstanceValues("/leaves", "hydra:instanceScales", 0, one));
  EXPECT_FALSE(leaves.scene.SetInstanceValues("/leaves", "hydra:instanceRotations", 0, one));
  EXPECT_FALSE(leaves.scene.SetInstanceValues("/leaves", kPlaces, 0, Vec3f(7)));
  EXPECT_FALSE(leaves.scene.SetInstanceValues("/leaves", kPlaces, 3, one));
  EXPECT_FALSE(leaves.scene.SetInstanceValues("/leaves", kPlaces, 2, two));
  EXPECT_FALSE(leaves.scene.SetInstanceValues("/leaves", kPlaces, ~size_t(0), two));
  EXPECT_TRUE(same(leaves.now(), in_a_row(3)));
  EXPECT_TRUE(leaves.scene.SetInstanceValues("/leaves", kPlaces, 1, two));
  EXPECT_EQ(leaves.now()[2], Vec3f(8));
}

TEST(InstanceValues, EditedValuesOfAMovingPrimvarStandStill) {
  Leaves leaves(in_a_row(3));
  InstancerDescription moving = leaves.scene.GetInstancers().at("/leaves");
  const std::vector<Vec3f> up(3, Vec3f(0, 1, 0));
  moving.primvarSamples[kPlaces] = {{0, 1}, {Array<Vec3f>(in_a_row(3)), Array<Vec3f>(up)}};
  leaves.scene.SetInstancer("/leaves", moving);
  ASSERT_TRUE(leaves.move(1, {Vec3f(7)}));
  const auto samples = leaves.scene.SamplePrimvar("/leaves", kPlaces);
  ASSERT_EQ(samples.values.size(), 2u);
  EXPECT_TRUE(same(*samples.values[0].get<Array<Vec3f>>(), {Vec3f(0), Vec3f(7), Vec3f(2, 0, 0)}));
  EXPECT_TRUE(same(*samples.values[1].get<Array<Vec3f>>(), {up[0], Vec3f(7), up[2]}));
  EXPECT_EQ(leaves.now()[1], Vec3f(7));

  moving.primvarSamples[kPlaces].values[1] = Array<Vec3f>(in_a_row(1));
  leaves.scene.SetInstancer("/leaves", moving);
  EXPECT_FALSE(leaves.move(1, {Vec3f(7)})) << "a sample has no such element";
  EXPECT_TRUE(same(leaves.now(), in_a_row(3)));
}

TEST(InstanceValues, SeveralPrimvarsAreSetTogetherOrNotAtAll) {
  Leaves leaves(in_a_row(3));
  const Array<Vec3f> two{Vec3f(7), Vec3f(8)};
  const Array<Quatf> turned{Quatf{0, 1, 0, 0}, Quatf{0, 0, 1, 0}}, too_many(std::vector<Quatf>(3));
  const char* const kTurns = "hydra:instanceRotations";
  EXPECT_FALSE(leaves.scene.SetInstanceValues("/leaves", 1, {{kPlaces, two}, {kTurns, too_many}}));
  EXPECT_FALSE(leaves.scene.SetInstanceValues("/leaves", 1, {{kPlaces, two}, {kTurns, two}}));
  EXPECT_FALSE(leaves.scene.SetInstanceValues("/leaves", 1, {{kPlaces, two}, {"none", two}}));
  EXPECT_TRUE(same(leaves.now(), in_a_row(3)));
  const auto last_turn = [&] {
    return (*leaves.scene.GetInstancers().at("/leaves").primvars.at(kTurns).get<Array<Quatf>>())[2];
  };
  const Quatf before = last_turn();  // its name comes before that of the places
  EXPECT_FALSE(leaves.scene.SetInstanceValues("/leaves", 1, {{kPlaces, Array<Vec3f>(in_a_row(3))}, {kTurns, turned}}));
  EXPECT_EQ(last_turn(), before);
  ASSERT_TRUE(leaves.scene.SetInstanceValues("/leaves", 1, {{kPlaces, two}, {kTurns, turned}}));
  EXPECT_TRUE(same(leaves.now(), {Vec3f(0), Vec3f(7), Vec3f(8)}));
  EXPECT_EQ(last_turn(), turned[1]);
}

TEST(InstanceValues, EditMarksTheInstancerAlone) {
  FakeDelegate delegate;
  RenderIndex index(&delegate);
  Leaves leaves(in_a_row(3));
  leaves.scene.SetMesh("/leaf", {});
  leaves.scene.Populate(&index);
  index.SyncAll();
  ASSERT_TRUE(leaves.move(0, {Vec3f(1)}));
  EXPECT_EQ(index.GetChangeTracker().Get("/leaves"), dirty::kPrimvar);
  EXPECT_EQ(index.GetChangeTracker().GetDirty().size(), 1u);
  leaves.scene.Depopulate();
}

}  // namespace
}  // namespace alabaster::hd::host
