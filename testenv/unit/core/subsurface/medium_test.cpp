#include "core/subsurface/medium.h"

#include <gtest/gtest.h>

#include <limits>

#include "testenv/support/albedo_table.h"
#include "testenv/support/anisotropic_half_space.h"
#include "testenv/support/half_space.h"
#include "testenv/support/van_de_hulst.h"

namespace alabaster {
namespace {

using testing::kAlbedoTable;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr AlbedoInversion kInversions[] = {AlbedoInversion::chiang2016, AlbedoInversion::exact};

TEST(AlbedoInversion, EveryRowOfTheTable) {
  for (const auto& row : kAlbedoTable) {
    const double exact = one_minus_alpha(row.albedo, AlbedoInversion::exact);
    // The column is rounded to its last printed digit.
    EXPECT_NEAR(exact, row.exact_one_minus_alpha, row.exact_one_minus_alpha * 3e-3) << row.albedo;
    EXPECT_NEAR(testing::half_space_albedo(exact), row.albedo, 2e-8);
    EXPECT_NEAR(testing::half_space_albedo(one_minus_alpha(row.albedo, AlbedoInversion::chiang2016)), row.chiang2016,
                5.1e-6)
        << row.albedo;
    // The column comes from the usual closed form of this inverse, whose rounded coefficients are off by 1.2e-5 at A =
    // 1; the helper has the root itself.
    EXPECT_NEAR(testing::half_space_albedo(testing::van_de_hulst_complement(row.albedo)) - row.albedo,
                row.van_de_hulst_error, 1.3e-5)
        << row.albedo;
  }
}

TEST(AlbedoInversion, EndsAreExactAndBeyondThemClamped) {
  for (const AlbedoInversion inversion : kInversions) {
    for (const double black : {0.0, -0.0, -1.0, -kInfinity, kNan})
      EXPECT_NEAR(one_minus_alpha(black, inversion), 1, 1e-15);
    const double at_one = one_minus_alpha(1, inversion);
    for (const double beyond : {1.0 + 1e-9, 7.0, kInfinity}) EXPECT_EQ(one_minus_alpha(beyond, inversion), at_one);
  }
  EXPECT_EQ(one_minus_alpha(0, AlbedoInversion::exact), 1);
  EXPECT_EQ(one_minus_alpha(1, AlbedoInversion::exact), 0);
  // Eq. 1 stops at alpha = 0.998886: white is out of its reach.
  EXPECT_NEAR(one_minus_alpha(1, AlbedoInversion::chiang2016), std::exp(-5.09406 + 2.61188 - 4.31805), 1e-15);
  EXPECT_NEAR(testing::half_space_albedo(one_minus_alpha(1, AlbedoInversion::chiang2016)), 0.92599, 5e-6);
}

// The tests' solver agrees with another method: testenv/walks/fit_anisotropic_inversion.py, 128 directions.
TEST(AnisotropicHalfSpaceSolution, IsTheDiscreteOrdinatesSolution) {
  constexpr double kKnown[][3] = {{-0.9, 0.5, 0.2502786709}, {-0.9, 0.01, 0.8475340929}, {-0.5, 0.1, 0.5468555899},
                                  {0.3, 0.01, 0.7600990986}, {0.7, 0.1, 0.2768330240},   {0.7, 1e-4, 0.9587718126},
                                  {0.9, 0.5, 0.0182542025},  {0.9, 0.01, 0.4934153756}};
  for (const auto& [g, complement, albedo] : kKnown)
    EXPECT_NEAR(testing::anisotropic_half_space_albedo(complement, g), albedo, 1e-7) << g << ' ' << complement;
}

TEST(AlbedoInversion, AnisotropicObtainsTheAlbedoAsked) {
  double worst = 0, worst_relative = 0;
  for (int i = -9; i <= 9; ++i)
    for (const double albedo : {0.005, 0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.99}) {
      const double g = i / 10.0;
      const double complement = one_minus_alpha(albedo, AlbedoInversion::exact, g);
      const double error = std::abs(testing::anisotropic_half_space_albedo(complement, g) - albedo);
      worst = std::max(worst, error);
      worst_relative = std::max(worst_relative, error / std::min(albedo, 1 - albedo));
    }
  EXPECT_LT(worst, 2.1e-5);
  EXPECT_LT(worst_relative, 4e-4);
}

TEST(AlbedoInversion, AnisotropicEndsAndOrder) {
  for (int i = -18; i <= 18; ++i) {
    const double g = i / 20.0;
    EXPECT_EQ(one_minus_alpha(0, AlbedoInversion::exact, g), 1);
    EXPECT_EQ(one_minus_alpha(1, AlbedoInversion::exact, g), 0);
    for (const AlbedoInversion inversion : kInversions)
      for (int k = 0; k < 1000; ++k)
        ASSERT_GT(one_minus_alpha(k / 1000.0, inversion, g), one_minus_alpha((k + 1) / 1000.0, inversion, g)) << g;
  }
  for (const double beyond : {0.91, 7.0, kInfinity})
    for (const double sign : {-1.0, 1.0})
      EXPECT_EQ(one_minus_alpha(0.5, AlbedoInversion::exact, sign * beyond),
                one_minus_alpha(0.5, AlbedoInversion::exact, sign * kMaxScatterAnisotropy));
}

TEST(AlbedoInversion, ObtainedAlbedoIsTheHalfSpaces) {
  for (const AlbedoInversion inversion : kInversions)
    for (const float albedo : {0.0f, 0.01f, 0.2f, 0.5f, 0.8f, 0.95f, 0.999f, 1.0f})
      EXPECT_NEAR(obtained_albedo(albedo, inversion), testing::half_space_albedo(one_minus_alpha(albedo, inversion)),
                  1e-6)
          << albedo;
}

TEST(DistanceScale, IsEquationTwo) {
  EXPECT_NEAR(distance_scale(0), 4.14, 1e-12);
  EXPECT_NEAR(distance_scale(0.2), 2.96, 1e-12);
  EXPECT_NEAR(distance_scale(0.5), 1.715, 1e-12);
  EXPECT_NEAR(distance_scale(0.8), 1.10, 1e-12);
  EXPECT_NEAR(distance_scale(1), 1.04, 1e-12);
  EXPECT_EQ(distance_scale(kNan), distance_scale(0));
  EXPECT_EQ(distance_scale(2), distance_scale(1));
}

TEST(MakeMedium, IsEquationThreePerChannel) {
  const Medium medium = make_medium({0.9f, 0.5f, 0.2f}, {2.0f, 1.0f, 0.25f}, AlbedoInversion::chiang2016);
  const double albedo[3] = {0.9f, 0.5f, 0.2f}, distance[3] = {2, 1, 0.25};
  for (int c = 0; c < 3; ++c) {
    EXPECT_TRUE(medium.active[c]);
    EXPECT_FLOAT_EQ(medium.sigma_t[c], static_cast<float>(1 / (distance[c] * distance_scale(albedo[c]))));
    const double complement = one_minus_alpha(albedo[c], AlbedoInversion::chiang2016);
    EXPECT_FLOAT_EQ(medium.one_minus_alpha[c], static_cast<float>(complement));
    EXPECT_FLOAT_EQ(medium.alpha[c], static_cast<float>(1 - complement));
  }
}

TEST(MakeMedium, AnisotropyKeepsTheReducedExtinction) {
  const Rgb albedo(0.9f, 0.5f, 0.2f), distance(2.0f, 1.0f, 0.25f);
  const Medium isotropic = make_medium(albedo, distance, AlbedoInversion::exact);
  EXPECT_EQ(isotropic.g, 0);
  for (const float g : {-0.9f, 0.3f, 0.9f}) {
    const Medium medium = make_medium(albedo, distance, AlbedoInversion::exact, g);
    EXPECT_EQ(medium.g, g);
    for (int c = 0; c < 3; ++c) {
      EXPECT_FLOAT_EQ(medium.sigma_t[c] * (1 - g), isotropic.sigma_t[c]);
      const double complement = one_minus_alpha(albedo[c], AlbedoInversion::exact, g);
      EXPECT_FLOAT_EQ(medium.one_minus_alpha[c], static_cast<float>(complement));
    }
  }
  EXPECT_EQ(make_medium(albedo, distance, AlbedoInversion::exact, 2.0f).g, static_cast<float>(kMaxScatterAnisotropy));
  EXPECT_EQ(make_medium(albedo, distance, AlbedoInversion::exact, std::numeric_limits<float>::quiet_NaN()).g, 0);
}

TEST(MakeMedium, ChannelsWithoutADistanceDoNotScatter) {
  for (const float none :
       {0.0f, -0.0f, -1.0f, std::numeric_limits<float>::quiet_NaN(), -std::numeric_limits<float>::infinity()}) {
    const Medium medium = make_medium({0.9f, 0.5f, 0.2f}, {1.0f, none, 1.0f}, AlbedoInversion::exact);
    EXPECT_TRUE(medium.active[0] && medium.active[2]);
    EXPECT_FALSE(medium.active[1]);
    EXPECT_EQ(medium.sigma_t.g, 0);
    EXPECT_EQ(medium.alpha.g, 0);
    EXPECT_EQ(medium.one_minus_alpha.g, 1);
  }
}

TEST(MakeMedium, ExtremesStayFinite) {
  const float tiny = std::numeric_limits<float>::denorm_min(), huge = std::numeric_limits<float>::max();
  const float infinite = std::numeric_limits<float>::infinity();
  const Medium medium = make_medium({1.0f, 0.0f, 0.5f}, {tiny, huge, infinite}, AlbedoInversion::exact);
  EXPECT_TRUE(medium.active[0] && medium.active[1] && medium.active[2]);
  EXPECT_GT(medium.sigma_t.r, 1e20f);
  EXPECT_TRUE(is_finite(medium.sigma_t));
  EXPECT_GE(medium.sigma_t.g, 0);
  EXPECT_EQ(medium.sigma_t.b, 0);
  EXPECT_EQ(medium.alpha.r, 1);
  EXPECT_EQ(medium.one_minus_alpha.r, 0);
  EXPECT_EQ(medium.alpha.g, 0);

  const float nan = std::numeric_limits<float>::quiet_NaN();
  const Medium wild = make_medium({nan, infinite, -1.0f}, {1, 1, 1}, AlbedoInversion::exact);
  EXPECT_EQ(wild.alpha, Rgb(0, 1, 0));
  EXPECT_TRUE(is_finite(wild.sigma_t));
}

TEST(MakeMedium, WhiteCarriesItsComplement) {
  const Medium medium = make_medium(Rgb(0.9999f), Rgb(1.0f), AlbedoInversion::exact);
  EXPECT_EQ(medium.alpha.r, 1);  // float cannot say it
  const double gap = 1 - static_cast<double>(0.9999f);
  EXPECT_NEAR(medium.one_minus_alpha.r, gap * gap * 3 / 16, 1e-3 * gap * gap);
}

}  // namespace
}  // namespace alabaster
