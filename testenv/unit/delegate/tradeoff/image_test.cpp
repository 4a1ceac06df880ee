#include "delegate/tradeoff/image.h"

#include <gtest/gtest.h>

#include <cmath>

namespace alabaster::tradeoff {
namespace {

const hd::host::OutputColors kBuiltIn{"built-in"};

TEST(DisplayError, IsTheRootOfTheMeanSquare) {
  const Image a{2, 1, {0, 0.5f, 1, 0.25f, 0.25f, 0.25f}};
  Image b = a;
  EXPECT_EQ(rmse(a, b), 0);
  b.rgb[1] += 0.5f;
  b.rgb[5] -= 0.25f;
  EXPECT_NEAR(rmse(a, b), std::sqrt((0.25 + 0.0625) / 6), 1e-12);
  EXPECT_EQ(rmse(a, b), rmse(b, a));
}

TEST(DisplayError, PicturesOfDifferentSizesHaveNone) {
  EXPECT_TRUE(std::isnan(rmse(Image{2, 1, std::vector<float>(6)}, Image{1, 2, std::vector<float>(6)})));
  EXPECT_TRUE(std::isnan(rmse(Image{}, Image{})));
}

TEST(DisplayError, LightThatADisplayCannotShowIsNoError) {
  const Image dim{1, 1, {2000, 2000, 2000}}, bright{1, 1, {9000, 9000, 9000}};
  const auto a = to_display(dim, {}, kBuiltIn, {}), b = to_display(bright, {}, kBuiltIn, {});
  ASSERT_TRUE(a && b);
  EXPECT_EQ(a->width, 1);
  EXPECT_LT(rmse(*a, *b), 0.01);
  EXPECT_GT(rmse(dim, bright), 1000);
}

TEST(DisplayError, WrongNamesAreReported) {
  std::vector<hd::Diagnostic> reports;
  hd::RenderProduct product;
  product.view = "no such view";
  const auto sink = [&](const hd::Diagnostic& d) { reports.push_back(d); };
  EXPECT_FALSE(to_display(Image{1, 1, {0, 0, 0}}, product, kBuiltIn, sink));
  ASSERT_EQ(reports.size(), 1u);
  EXPECT_NE(reports[0].text.find("no such view"), std::string::npos) << reports[0].text;
  EXPECT_FALSE(to_display(Image{1, 1, {0, 0, 0}}, {}, {"/no/such/config.ocio"}, sink));
  EXPECT_EQ(reports.size(), 2u);
}

}  // namespace
}  // namespace alabaster::tradeoff
