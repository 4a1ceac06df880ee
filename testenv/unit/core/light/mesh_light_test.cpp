#include "core/light/mesh_light.h"

#include <gtest/gtest.h>

#include <limits>

#include "core/sampling/pixel_sampler.h"

namespace alabaster {
namespace {

MeshLight::Triangle triangle(float z, float size, const Rgb& radiance) {
  return {{0, 0, z}, {size, 0, z}, {0, size, z}, radiance};
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
