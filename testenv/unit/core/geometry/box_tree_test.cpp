#include "core/geometry/box_tree.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "testenv/support/random_point.h"

namespace alabaster {
namespace {

TEST(BoxTree, FindsWhatAdmitsAndNoOthers) {
  Rng rng(5, 9);
  for (const size_t count : std::initializer_list<size_t>{0, 1, 2, 3, 7, 1000}) {
    std::vector<Bounds> boxes;
    for (size_t i = 0; i < count; ++i) {
      const Vec3f at = i % 5 == 1 ? boxes.back().lower : test::random_point(rng);
      boxes.push_back({at, at + test::random_point(rng) * 0.2f});
    }
    const BoxTree tree(boxes);
    ASSERT_EQ(tree.size(), count);
    for (int k = 0; k < 200; ++k) {
      const Vec3f p = test::random_point(rng) * 1.2f;
      std::vector<uint32_t> found, expected;
      tree.search([&](const Bounds& b) { return b.contains(p); }, [&](uint32_t box) { found.push_back(box); });
      for (uint32_t i = 0; i < count; ++i)
        if (boxes[i].contains(p)) expected.push_back(i);
      std::sort(found.begin(), found.end());
      ASSERT_EQ(found, expected) << count;
    }
  }
}

}  // namespace
}  // namespace alabaster
