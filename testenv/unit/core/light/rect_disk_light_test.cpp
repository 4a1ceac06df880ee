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

}  // namespace
}  // namespace alabaster
