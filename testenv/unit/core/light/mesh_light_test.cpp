#include "core/light/mesh_light.h"

#include <gtest/gtest.h>

#include <limits>

#include "core/sampling/pixel_sampler.h"

namespace alabaster {
namespace {

MeshLight::Triangle triangle(float z, float size, const Rgb& radiance) {
  return {{0, 0, z}, {size, 0, z}, {0, size, z}, radiance};
}

TEST(MeshLight, PdfOfAHitIsThatOfTheSample) {
  const MeshLight light(3, {triangle(1, 1, Rgb(1.0f)), triangle(-2, 3, Rgb(0, 2, 0))}, {10, 20});
  EXPECT_EQ(light.instance(), 3u);
  Rng rng(1, 1);
  const Vec3f p(0.2f, -0.4f, 0.3f);
  for (int i = 0; i < 1000; ++i) {
    const float x = rng.uniform();
    const auto s = light.sample(p, {x, rng.uniform()});
    ASSERT_TRUE(s);
    EXPECT_FALSE(s->delta);
    const uint32_t id = s->wi.z > 0 ? 10 : 20;
    EXPECT_NEAR((p + s->wi * s->distance).z, id == 10 ? 1 : -2, 1e-5f);
    EXPECT_EQ(s->radiance, id == 10 ? Rgb(1.0f) : Rgb(0, 2, 0));
    EXPECT_NEAR(light.pdf(id, s->wi, s->distance) / s->pdf, 1, 1e-5f);
  }
}

// By hand: areas 1/2 and 2 at luminance 1 are chosen 1 : 4; d = 2 straight on, so pdf = 4/5 / 2 * 4 / 1.
TEST(MeshLight, DensityIsAreaToSolidAngle) {
  const MeshLight light(0, {triangle(1, 1, Rgb(1.0f)), triangle(-2, 2, Rgb(1.0f))}, {0, 1});
  EXPECT_NEAR(light.pdf(1, {0, 0, -1}, 2), 1.6f, 1e-6f);
  EXPECT_NEAR(light.pdf(0, {0, 0, 1}, 1), 0.4f, 1e-6f);
  EXPECT_NEAR(light.pdf(0, {0, 0, -1}, 1), 0.4f, 1e-6f) << "both sides";
  EXPECT_EQ(light.pdf(2, {0, 0, 1}, 1), 0) << "not of this light";
  EXPECT_EQ(light.pdf(0, {1, 0, 0}, 1), 0) << "edge-on";
  // Bounds (0,0,-2) to (2,2,1): half of area times luminance over the squared distance and radius.
  EXPECT_NEAR(light.importance({1, 1, 9.5f}), 0.5 * 2.5 / (100 + 4.25), 1e-6);
}

TEST(MeshLight, TrianglesWithoutLightOrAreaAreNeverChosen) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  MeshLight::Triangle sliver = triangle(5, 1, Rgb(1.0f)), broken = sliver;
  sliver.p2 = sliver.p1;
  broken.p0.x = nan;
  const MeshLight light(0,
                        {triangle(-5, 9, Rgb(0.0f)), sliver, broken, triangle(1, 1, Rgb(1.0f)),
                         triangle(-5, 9, Rgb(nan, 1, 1)), triangle(-5, 9, Rgb(-1, -1, -1))},
                        {0, 1, 2, 3, 4, 5});
  Rng rng(1, 1);
  for (int i = 0; i < 1000; ++i) {
    const float x = rng.uniform();
    const auto s = light.sample({0, 0, 0}, {x, rng.uniform()});
    ASSERT_TRUE(s);
    EXPECT_GT(s->wi.z, 0);
  }
  for (uint32_t id : {0u, 1u, 2u, 4u, 5u}) EXPECT_EQ(light.pdf(id, {0, 0, 1}, 1), 0);
  EXPECT_FALSE(MeshLight(0, {}, {}).sample({0, 0, 0}, {0, 0}));
  EXPECT_FALSE(MeshLight(0, {sliver}, {0}).sample({0, 0, 0}, {0, 0}));
  EXPECT_EQ(MeshLight(0, {sliver}, {0}).importance({0, 0, 0}), 0);
}

}  // namespace
}  // namespace alabaster
