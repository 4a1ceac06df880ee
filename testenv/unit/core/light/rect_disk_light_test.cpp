#include "core/light/rect_disk_light.h"

#include <gtest/gtest.h>

#include "testenv/support/memory_texture.h"

namespace alabaster {
namespace {

TEST(RectDiskLight, EmitsDownLocalMinusZOnly) {
  LightParameters d;
  d.intensity = 2;
  const RectDiskLight light(d, Vec3d(0, 0, 0));
  EXPECT_TRUE(light.sample({0, 0, -1}, {0.5f, 0.5f}));
  EXPECT_FALSE(light.sample({0, 0, 1}, {0.5f, 0.5f}));
  EXPECT_FALSE(light.sample({3, 0, 0}, {0.5f, 0.5f})) << "in its plane";
  const auto hit = light.intersect({{0.2f, 0.3f, -2}, {0, 0, 0.5f}});
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->t, 4);
  EXPECT_EQ(hit->radiance, Rgb(2.0f));
  EXPECT_FALSE(light.intersect({{0.2f, 0.3f, 2}, {0, 0, -1}})) << "from behind";
  EXPECT_FALSE(light.intersect({{0.2f, 0.3f, -2}, {0, 0, -1}})) << "away";
  EXPECT_FALSE(light.intersect({{0.6f, 0.3f, -2}, {0, 0, 1}})) << "beside";
}

TEST(RectDiskLight, MirroringKeepsTheEmittingSideLocal) {
  LightParameters d;
  d.light_to_world = Matrix4d(-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1);  // mirrors x
  EXPECT_TRUE(RectDiskLight(d, Vec3d(0, 0, 0)).sample({0, 0, -1}, {0.5f, 0.5f}));
  d.light_to_world = Matrix4d(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1);  // mirrors z
  EXPECT_TRUE(RectDiskLight(d, Vec3d(0, 0, 0)).sample({0, 0, 1}, {0.5f, 0.5f}));
}

// A cube's face seen from its centre is a sixth of the sphere.
TEST(RectDiskLight, PdfIsOneOverTheSolidAngle) {
  LightParameters d;
  d.width = d.height = 2;
  const auto s = RectDiskLight(d, Vec3d(0, 0, 1)).sample({0, 0, -2}, {0.3f, 0.8f});
  ASSERT_TRUE(s);
  EXPECT_NEAR(s->pdf, 6 / (4 * kPi), 1e-6f);
}

TEST(RectDiskLight, SizesTimesScaleAndNormalize) {
  LightParameters d;
  d.width = 3;
  d.height = 0.5f;
  d.light_to_world = Matrix4d(2, 0, 0, 0, 0, 4, 0, 0, 0, 0, 7, 0, 0, 0, 0, 1);
  const RectDiskLight light(d, Vec3d(0, 0, 0));
  EXPECT_TRUE(light.intersect({{2.9f, 0.9f, -1}, {0, 0, 1}}));
  EXPECT_FALSE(light.intersect({{3.1f, 0.9f, -1}, {0, 0, 1}}));
  EXPECT_FALSE(light.intersect({{2.9f, 1.1f, -1}, {0, 0, 1}}));
  d.normalize = true;
  const RectDiskLight normalized(d, Vec3d(0, 0, 0));
  EXPECT_NEAR(normalized.intersect({{0, 0, -1}, {0, 0, 1}})->radiance.r, 1.0f / 12, 1e-7f);
}

// Estimates solid angles of squares seen straight on, 4 asin(a^2 / (a^2 + z^2)) for half edge a.
TEST(RectDiskLight, ImportanceFollowsTheSolidAngleInFrontAndIsZeroBehind) {
  const RectDiskLight light({}, Vec3d(0, 0, 0));
  for (double z : {0.01, 0.3, 1.0, 30.0, 1e4}) {
    const double solid_angle = 4 * std::asin(0.25 / (0.25 + z * z));
    const double importance = light.importance({0, 0, static_cast<float>(-z)});
    EXPECT_GT(importance, 0.45 * solid_angle) << z;
    EXPECT_LT(importance, 1.05 * solid_angle) << z;
  }
  EXPECT_GT(light.importance({0.45f, 0.45f, -0.01f}), 0.5) << "overhead, if not its centre";
  EXPECT_LT(light.importance({100, 0, -0.01f}), 0.05 * light.importance({0, 0, -100})) << "grazing";
  EXPECT_GT(light.importance({100, 0, -0.01f}), 0);
  EXPECT_EQ(light.importance({100, 0, 0}), 0);
  EXPECT_EQ(light.importance({0, 0, 1}), 0);
}

// The random numbers' square covers the rectangle without folding: corners go to corners, from near and far.
TEST(RectDiskLight, SamplesSpanTheRectangle) {
  const RectDiskLight light({}, Vec3d(0, 0, 0));
  for (const Vec3f& p : {Vec3f(0.1f, 0.2f, -0.01f), Vec3f(2, -1, -0.5f), Vec3f(100, 100, -100), Vec3f(0, 0, -300)})
    for (float x : {0.0f, kOneMinusEpsilon})
      for (float y : {0.0f, kOneMinusEpsilon}) {
        const auto s = light.sample(p, {x, y});
        ASSERT_TRUE(s);
        const Vec3f q = p + s->wi * s->distance;
        const float tolerance = 1e-4f + 3e-7f * s->distance;
        EXPECT_NEAR(q.x, x == 0 ? -0.5f : 0.5f, tolerance);
        EXPECT_NEAR(std::abs(q.y), 0.5f, tolerance);
        EXPECT_NEAR(q.z, 0, tolerance);
      }
}

// Upright for who looks at the emitting side with +y up: its first texel lies at (+x, +y).
TEST(RectDiskLight, ImagesAreUprightFromInFront) {
  LightParameters d;
  d.width = 2;
  d.intensity = 3;
  const std::vector<Rgb> texels = {Rgb(1.0f), Rgb(2.0f), Rgb(3.0f), Rgb(4.0f)};  // two rows from the top
  d.texture = std::make_shared<testing::MemoryTexture>(2, texels);
  const RectDiskLight light(d, Vec3d(0, 0, 0));
  const auto at = [&](float x, float y) { return light.intersect({{x, y, -1}, {0, 0, 1}})->radiance.g; };
  EXPECT_FLOAT_EQ(at(0.9f, 0.4f), 3);
  EXPECT_FLOAT_EQ(at(-0.9f, 0.4f), 6);
  EXPECT_FLOAT_EQ(at(0.9f, -0.4f), 9);
  EXPECT_FLOAT_EQ(at(-0.9f, -0.4f), 12);
  EXPECT_NEAR(at(0, 0), 7.5f, 1e-4f) << "bilinear";
  EXPECT_NEAR(light.importance({0, 0, -100}) * 1e4, 7.5 * 2, 0.1) << "of the mean";
}

LightParameters disk(float radius) {
  LightParameters d;
  d.type = LightType::disk;
  d.radius = radius;
  return d;
}

TEST(RectDiskLight, DisksAreRoundAndBecomeEllipses) {
  LightParameters d = disk(2);
  d.normalize = true;
  d.light_to_world = Matrix4d(3, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1);  // mirrors y
  const RectDiskLight light(d, Vec3d(0, 0, 0));
  const auto at = [&](double x, double y) {
    return light.intersect({{static_cast<float>(x), static_cast<float>(y), -1}, {0, 0, 1}});
  };
  ASSERT_TRUE(at(5.9, 0.1));
  EXPECT_NEAR(at(5.9, 0.1)->radiance.r, 1 / (12 * kPi), 1e-7f);
  EXPECT_TRUE(at(4.2, -1.4));
  EXPECT_FALSE(at(4.3, 1.5)) << "in the corner of the square";
  EXPECT_FALSE(at(0, 2.1));
}

// Seen on its axis, E = pi L sin^2. Near points sample the square around the disk, others its area; the samples of both
// are the disk's.
TEST(RectDiskLight, DisksAreSampledFromNearAndFar) {
  for (double z : {0.01, 0.7, 0.8, 100.0}) {
    const RectDiskLight light(disk(1), Vec3d(0, 0, 0));
    const Vec3f p(0, 0, static_cast<float>(-z));
    double irradiance = 0;
    constexpr int kSide = 200;
    for (int i = 0; i < kSide * kSide; ++i) {
      const Vec2f u((static_cast<float>(i % kSide) + 0.5f) / kSide, (static_cast<float>(i / kSide) + 0.5f) / kSide);
      const auto s = light.sample(p, u);
      if (!s) continue;
      const Vec3f q = p + s->wi * s->distance;
      EXPECT_LE(q.x * q.x + q.y * q.y, 1 + 1e-5f);
      irradiance += static_cast<double>(s->wi.z / s->pdf) / (kSide * kSide);
    }
    EXPECT_NEAR(irradiance * (1 + z * z) / kPiDouble, 1, 2e-3) << z;
  }
}

}  // namespace
}  // namespace alabaster
