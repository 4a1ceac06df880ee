#include "core/light/dome_light.h"

#include <gtest/gtest.h>

#include "testenv/support/memory_texture.h"

namespace alabaster {
namespace {

using testing::MemoryTexture;

LightParameters dome(int width, std::vector<Rgb> texels) {
  LightParameters d;
  d.type = LightType::dome;
  d.texture = std::make_shared<MemoryTexture>(width, std::move(texels));
  return d;
}

Rgb seen(const DomeLight& light, const Vec3f& direction) {
  const auto hit = light.intersect({{1, 2, 3}, direction});
  return hit ? hit->radiance : Rgb(0.0f);
}

// Columns of an 8 x 4 image from the left: longitudes +pi .. -pi. Directions of texel centres; longitude l is
// (sin l, 0, cos l).
TEST(DomeLight, OrientationIsOpenUsds) {
  std::vector<Rgb> texels(32, Rgb(0.0f));
  for (size_t y = 0; y < 4; ++y)
    for (size_t x = 0; x < 8; ++x) texels[y * 8 + x] = Rgb(static_cast<float>(x + 1), static_cast<float>(y + 1), 0);
  const DomeLight light(dome(8, texels), Vec3d(0, 0, 0));
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 8; ++x) {
      const double longitude = kPiDouble * (1 - (x + 0.5) / 4), latitude = kPiDouble * (0.5 - (y + 0.5) / 4);
      const Vec3f w(Vec3d(std::cos(latitude) * std::sin(longitude), std::sin(latitude),
                          std::cos(latitude) * std::cos(longitude)));
      EXPECT_NEAR(seen(light, w).r, x + 1, 1e-5);
      EXPECT_NEAR(seen(light, w).g, y + 1, 1e-5);
    }
  EXPECT_NEAR(seen(light, {0, 0, 1}).r, 4.5f, 1e-5f) << "the centre looks along +z";
  EXPECT_NEAR(seen(light, {1, 0, 0}).r, 2.5f, 1e-5f) << "+x is left of it";
  EXPECT_NEAR(seen(light, {-1, 0, 0}).r, 6.5f, 1e-5f);
  EXPECT_NEAR(seen(light, {1e-6f, 0, -1}).r, 4.5f, 1e-4f) << "the edges meet at -z: the mean of 1 and 8";
  EXPECT_EQ(seen(light, {0, 1, 0}).g, 1) << "top row up";
  EXPECT_EQ(seen(light, {0, -5, 0}).g, 4);
}

TEST(DomeLight, TurnsAndMirrorsButDoesNotScale) {
  std::vector<Rgb> texels(8, Rgb(0.0f));
  texels[1] = Rgb(7.0f);  // 4 x 2: left half of the upper half, about longitude pi/4, latitude pi/4
  LightParameters d = dome(4, texels);
  const Vec3f w(0.5f, std::sqrt(0.5f), 0.5f);
  EXPECT_NEAR(seen(DomeLight(d, Vec3d(0, 0, 0)), w).r, 7, 1e-4f);
  d.light_to_world = Matrix4d(0, 0, -5, 0, 0, 0.1, 0, 0, 2, 0, 0, 0, 1, 1, 1, 1);  // local x is -z, local z is x
  EXPECT_NEAR(seen(DomeLight(d, Vec3d(0, 0, 0)), {0.5f, std::sqrt(0.5f), -0.5f}).r, 7, 1e-4f);
  d.light_to_world = Matrix4d(-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1);
  EXPECT_NEAR(seen(DomeLight(d, Vec3d(0, 0, 0)), {-0.5f, std::sqrt(0.5f), 0.5f}).r, 7, 1e-4f);
}

// The pdf must cover the spread of filtering: every direction with radiance can be sampled.
TEST(DomeLight, PdfIsPositiveWhereverThereIsLight) {
  std::vector<Rgb> texels(size_t{16} * 8, Rgb(0.0f));
  texels[5] = texels[16 * 4] = texels[16 * 7 + 15] = Rgb(0, 0, 1);  // the top row, a seam, a corner
  texels[16 * 3 + 9] = Rgb(1e6f);
  const DomeLight light(dome(16, texels), Vec3d(0, 0, 0));
  int lit = 0;
  for (int y = 0; y < 160; ++y)
    for (int x = 0; x < 320; ++x) {
      const double theta = kPiDouble * (y + 0.5) / 160, phi = 2 * kPiDouble * (x + 0.5) / 320;
      const auto hit = light.intersect(
          {{0, 0, 0}, Vec3f(Vec3d(std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi)))});
      if (!hit) continue;
      ++lit;
      ASSERT_GT(hit->pdf, 0) << x << ' ' << y;
    }
  EXPECT_GT(lit, 1000);
}

// The filter spreads a sun of one texel over nine. The density follows it, so a sample that finds the sun does not
// depend on where in it; with a density that is constant per texel its standard deviation would be 1.1 of its mean.
TEST(DomeLight, ASunGivesNoNoiseOfItsOwn) {
  std::vector<Rgb> texels(size_t{64} * 32, Rgb(0.0f));
  texels[64 * 9 + 20] = Rgb(4e4f, 3e4f, 2e4f);
  texels[64 * 9 + 21] = Rgb(2e4f, 1.5e4f, 1e4f);
  const DomeLight light(dome(64, texels), Vec3d(0, 0, 0));
  double sum = 0, squares = 0;
  constexpr int kSide = 64;
  for (int i = 0; i < kSide * kSide; ++i) {
    const Vec2f u((static_cast<float>(i % kSide) + 0.5f) / kSide, (static_cast<float>(i / kSide) + 0.5f) / kSide);
    const auto s = light.sample({0, 0, 0}, u);
    ASSERT_TRUE(s) << i;
    const double value = s->radiance.g / s->pdf;
    sum += value / (kSide * kSide);
    squares += value * value / (kSide * kSide);
  }
  EXPECT_LT(std::sqrt(squares - sum * sum), 0.02 * sum);
}

TEST(DomeLight, BadTexelsAreCleaned) {
  const float inf = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
  const DomeLight light(dome(2, {Rgb(inf, nan, -3), Rgb(1.0f)}), Vec3d(0, 0, 0));
  EXPECT_EQ(seen(light, {1, 0, 0}), Rgb(65504, 0, 0));
  EXPECT_EQ(seen(light, {-1, 0, 0}), Rgb(1.0f));
  EXPECT_TRUE(std::isfinite(light.importance({0, 0, 0})));
  EXPECT_TRUE(light.sample({0, 0, 0}, {0.2f, 0.7f}));
}

// The irradiance of a plane, averaged over its orientations.
TEST(DomeLight, ImportanceIsPiTimesTheMeanOverTheSphere) {
  LightParameters d = dome(2, {Rgb(1.0f), Rgb(3.0f), Rgb(0.0f), Rgb(0.0f)});
  EXPECT_NEAR(DomeLight(d, Vec3d(0, 0, 0)).importance({0, 0, 0}), kPi, 1e-6);  // mean 1
  d.texture = nullptr;
  d.color = Rgb(0, 1, 0);
  EXPECT_NEAR(DomeLight(d, Vec3d(0, 0, 0)).importance({1, 2, 3}), 0.7152 * kPi, 1e-6);
}

TEST(DomeLight, OneTexelIsAConstantDome) {
  const DomeLight light(dome(1, {Rgb(2.0f)}), Vec3d(0, 0, 0));
  for (const Vec2f& u : {Vec2f(0, 0), Vec2f(0.3f, 0.4f), Vec2f(kOneMinusEpsilon, kOneMinusEpsilon)}) {
    const auto s = light.sample({0, 0, 0}, u);
    ASSERT_TRUE(s);
    EXPECT_NEAR(s->pdf, 1 / (4 * kPi), 1e-7f);
    EXPECT_EQ(s->radiance, Rgb(2.0f));
  }
}

}  // namespace
}  // namespace alabaster
