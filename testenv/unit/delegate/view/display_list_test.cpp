// Displays and views as menus list them.
#include "delegate/view/display_list.h"

#include <gtest/gtest.h>

#include "delegate/host/product_writer.h"

namespace alabaster::view {
namespace {

TEST(DisplayList, DefaultsComeFirst) {
  const auto list = read_displays(
      "configuration: some\ncolour spaces:\n  Raw\ndisplays (* is the default):\n  Wall\n    Film\n    Log *\n"
      "  Desk *\n    Plain *\nlooks:\n  Warm\n");
  ASSERT_EQ(list.size(), 2u);
  EXPECT_EQ(list[0].name, "Desk");
  EXPECT_EQ(list[0].views, std::vector<std::string>{"Plain"});
  EXPECT_EQ(list[1].name, "Wall");
  EXPECT_EQ(list[1].views, (std::vector<std::string>{"Log", "Film"}));
}

TEST(DisplayList, ReadsTheBuiltInConfiguration) {
  const auto list = read_displays(hd::host::DescribeColors({}, {}));
  ASSERT_FALSE(list.empty());
  for (const DisplayChoice& display : list) EXPECT_FALSE(display.views.empty()) << display.name;
  EXPECT_EQ(list[0].name, "sRGB");
  EXPECT_EQ(list[0].views[0], "ACES");
}

}  // namespace
}  // namespace alabaster::view
