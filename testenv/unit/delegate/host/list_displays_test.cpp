// Displays and views as menus list them.
#include <gtest/gtest.h>

#include "delegate/host/product_writer.h"

namespace alabaster::hd::host {
namespace {

TEST(ListDisplays, DefaultDisplaysComeFirst) {
  const auto list = ListDisplays({}, {});
  ASSERT_FALSE(list.empty());
  EXPECT_EQ(list[0].name, "sRGB");
  EXPECT_EQ(list[0].views[0], "ACES");
  const std::string described = DescribeColors({}, {});
  for (const ColorDisplay& display : list) {
    EXPECT_FALSE(display.views.empty()) << display.name;
    const bool is_first = &display == list.data();
    EXPECT_NE(described.find("  " + display.name + (is_first ? " *\n" : "\n")), std::string::npos) << display.name;
    for (const std::string& view : display.views)
      EXPECT_NE(described.find("    " + view + (view == display.views[0] ? " *\n" : "\n")), std::string::npos) << view;
  }
}

TEST(ListDisplays, AConfigurationThatCannotBeReadIsReported) {
  std::vector<Diagnostic> reports;
  OutputColors colors;
  colors.ocio = "/nowhere/missing.ocio";
  EXPECT_TRUE(ListDisplays(colors, [&](const Diagnostic& d) { reports.push_back(d); }).empty());
  ASSERT_EQ(reports.size(), 1u);
  EXPECT_NE(reports[0].where.find("missing.ocio"), std::string::npos) << reports[0].where;
}

}  // namespace
}  // namespace alabaster::hd::host
