#include "core/color/blackbody.h"

#include <gtest/gtest.h>

#include <array>

namespace alabaster {
namespace {

std::array<double, 3> xyz_of(const Rgb& c, const Chromaticities& space) {
  const XyzColumns columns = xyz_d65_columns(space);
  std::array<double, 3> xyz{};
  for (size_t j = 0; j < 3; ++j) xyz[j] = c.r * columns[0][j] + c.g * columns[1][j] + c.b * columns[2][j];
  return xyz;
}

// CIE 1931 xy of the Planckian locus (Wyszecki and Stiles 2000, table 1(3.11) and CIE 15, illuminant A).
TEST(Blackbody, HasThePublishedChromaticities) {
  struct Case {
    float kelvin;
    double x, y;
  };
  for (const auto& [kelvin, x, y] :
       {Case{2000, 0.5267, 0.4133}, Case{2700, 0.4599, 0.4106}, Case{2856, 0.4476, 0.4074}, Case{4000, 0.3805, 0.3768},
        Case{6500, 0.3135, 0.3237}, Case{10000, 0.2807, 0.2884}}) {
    const auto xyz = xyz_of(blackbody(kelvin, kRec709), kRec709);
    const double sum = xyz[0] + xyz[1] + xyz[2];
    EXPECT_NEAR(xyz[0] / sum, x, 4e-4) << kelvin;
    EXPECT_NEAR(xyz[1] / sum, y, 4e-4) << kelvin;
    EXPECT_NEAR(xyz[1], 1, 1e-6) << kelvin << ": luminance";
  }
}

TEST(Blackbody, IsNearlyWhiteAtD65) {
  const Rgb c = blackbody(6500, kRec709);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(c[i], 1, 0.05);
}

// The same light in a wider space, and channels outside a narrow one are cut.
TEST(Blackbody, IsOneColourInEverySpace) {
  const Chromaticities rec2020 = {0.708f, 0.292f, 0.170f, 0.797f, 0.131f, 0.046f, 0.3127f, 0.3290f};
  const auto a = xyz_of(blackbody(3200, kRec709), kRec709), b = xyz_of(blackbody(3200, rec2020), rec2020);
  for (size_t j = 0; j < 3; ++j) EXPECT_NEAR(a[j], b[j], 1e-5);
  EXPECT_EQ(blackbody(1000, kRec709).b, 0);
  EXPECT_GT(blackbody(1000, kRec709).r, 1);
  EXPECT_EQ(blackbody(500, kRec709), blackbody(1000, kRec709));
}

}  // namespace
}  // namespace alabaster
