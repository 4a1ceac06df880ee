#include "core/geometry/grouped_items.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <utility>

#include "core/sampling/pixel_sampler.h"

namespace alabaster {
namespace {

using Items = std::vector<std::pair<size_t, uint32_t>>;  // group, item

GroupedItems<uint32_t> grouped(size_t groups, const Items& items, const CancelToken& cancel = {}) {
  const auto each = [&](const auto& add) {
    for (const auto& [group, item] : items) add(group, item);
  };
  return {groups, each, cancel};
}

/// Most items in the last of the groups.
Items many_items(size_t groups, size_t count) {
  Rng rng(7, 1);
  Items items;
  for (size_t i = 0; i < count; ++i)
    items.emplace_back(rng.uniform() < 0.9f ? groups - 1 : rng.next() % groups, rng.next() % 1000);
  return items;
}

TEST(GroupedItems, AreInTheOrderOfASortByGroupAndItem) {
  constexpr size_t kGroups = 1000;
  Items expected = many_items(kGroups, 50000);
  const GroupedItems<uint32_t> found = grouped(kGroups, expected);
  std::sort(expected.begin(), expected.end());
  Items all;
  for (size_t g = 0; g < found.size(); ++g)
    for (const uint32_t item : found[g]) all.emplace_back(g, item);
  EXPECT_EQ(found.size(), kGroups);
  EXPECT_EQ(all, expected);
}

TEST(GroupedItems, EmptyListsGiveEmptyGroups) {
  EXPECT_EQ(grouped(0, {}).size(), 0u);
  const auto empty = grouped(3, {});
  EXPECT_EQ(empty.size(), 3u);
  for (size_t g = 0; g < 3; ++g) EXPECT_TRUE(empty[g].empty());
}

TEST(GroupedItems, FallIntoRunsOfLikeOnes) {
  const auto found = grouped(2, {{1, 5}, {1, 3}, {0, 9}, {1, 5}, {1, 3}, {1, 4}});
  std::vector<std::vector<uint32_t>> runs;
  for_each_run(found[1], std::equal_to<uint32_t>(),
               [&](std::span<const uint32_t> run) { runs.emplace_back(run.begin(), run.end()); });
  EXPECT_EQ(runs, (std::vector<std::vector<uint32_t>>{{3, 3}, {4}, {5, 5}}));
}

TEST(GroupedItems, MayBeCancelled) {
  const std::atomic<bool> cancelled = true;
  EXPECT_THROW(grouped(10, many_items(10, 100), CancelToken(&cancelled)), BuildCancelled);
}

}  // namespace
}  // namespace alabaster
