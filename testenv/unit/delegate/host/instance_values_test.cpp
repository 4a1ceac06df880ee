// Edits of parts of an instancer's arrays, while others still read the arrays of before.
#include <gtest/gtest.h>

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

}  // namespace
}  // namespace alabaster::hd::host
