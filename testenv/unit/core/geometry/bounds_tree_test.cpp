#include "core/geometry/bounds_tree.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "testenv/support/random_point.h"

namespace alabaster {
namespace {

TEST(BoundsTree, VisitsTheBoxesThatHoldAPointAndNoOthers) {
  Rng rng(3, 7);
  std::vector<Bounds> boxes;
  for (int i = 0; i < 3000; ++i) {
    const Vec3f at = test::random_point(rng);
    const float size = i % 10 == 0 ? 0.0f : 0.1f;
    boxes.push_back({at, at + test::random_point(rng) * size});
  }
  boxes[5] = Bounds();  // holds nothing
  const auto tree = build_bounds_tree(make_trace_device({}), boxes);
  ASSERT_TRUE(tree);
  size_t found = 0;
  for (int i = 0; i < 2000; ++i) {
    // Corners count as within.
    const Vec3f p = i % 4 == 0 ? boxes[static_cast<size_t>(i)].upper : test::random_point(rng) * 1.2f;
    std::vector<uint32_t> visited, expected;
    EXPECT_FALSE(tree->any_at(p, [&](uint32_t box) { return visited.push_back(box), false; }));
    for (uint32_t b = 0; b < boxes.size(); ++b)
      if (boxes[b].contains(p)) expected.push_back(b);
    std::sort(visited.begin(), visited.end());
    ASSERT_EQ(visited, expected) << i;
    found += expected.size();
    EXPECT_EQ(tree->any_at(p, [](uint32_t) { return true; }), !expected.empty());
  }
  EXPECT_GT(found, 500u);
  EXPECT_FALSE(tree->any_at(Vec3f(std::numeric_limits<float>::quiet_NaN()), [](uint32_t) { return true; }));
}

TEST(BoundsTree, ABuildMayBeCancelled) {
  const std::vector<Bounds> boxes(100, {Vec3f(0.0f), Vec3f(1.0f)});
  EXPECT_EQ(build_bounds_tree(make_trace_device({}), boxes, [] { return true; }), nullptr);
}

}  // namespace
}  // namespace alabaster
