#include "delegate/support/lookup.h"

#include <gtest/gtest.h>

#include <map>

namespace alabaster::hd::support {
namespace {

TEST(AscendingLookupTest, FindsWhatASearchFinds) {
  const std::map<int, int> values{{2, 20}, {3, 30}, {5, 50}, {8, 80}};
  for (int left_out = -1; left_out < 10; ++left_out) {
    AscendingLookup lookup(values);
    for (int name = 0; name < 10; ++name) {
      if (name == left_out) continue;
      EXPECT_EQ(lookup.find(name), find_in(values, name)) << name << " without " << left_out;
    }
  }
}

TEST(AscendingLookupTest, FindsNothingInAnEmptyMap) {
  std::map<int, int> none;
  EXPECT_EQ(AscendingLookup(none).find(1), nullptr);
}

}  // namespace
}  // namespace alabaster::hd::support
