#include "core/light/light_tree.h"

#include <gtest/gtest.h>

#include "core/sampling/pixel_sampler.h"

namespace alabaster {
namespace {

Vec3f random_point(Rng& rng, float size) {
  const float x = rng.uniform(), y = rng.uniform();
  return Vec3f(2 * x - 1, 2 * y - 1, 2 * rng.uniform() - 1) * size;
}

/// Lights of all types that rays can meet, at random places, two of them infinite and one nowhere.
std::vector<Light> many_lights(uint32_t count, double scale = 1) {
  Rng rng(7, 1);
  std::vector<Light> lights;
  for (uint32_t i = 0; i < count; ++i) {
    LightParameters d;
    d.type = i == 5 || i == 9 ? LightType::distant : i % 3 == 0 ? LightType::sphere : LightType::rect;
    d.intensity = 1 + 20 * rng.uniform() * rng.uniform();
    const Vec3f place = random_point(rng, 10);
    for (int k = 0; k < 3; ++k) {
      d.light_to_world[k][k] = (0.1 + static_cast<double>(rng.uniform())) * scale;
      d.light_to_world[3][k] = i == 11 ? 1e300 : static_cast<double>(place[k]) * scale;
    }
    if (i % 4 == 1) {  // faces along y
      std::swap(d.light_to_world[1][1], d.light_to_world[1][2]);
      std::swap(d.light_to_world[2][2], d.light_to_world[2][1]);
    }
    lights.push_back(make_light(d, Vec3d(0, 0, 0)));
  }
  return lights;
}

TEST(LightTree, PrefersWhatIsNearAndStrong) {
  std::vector<Light> lights;
  for (int i = 0; i < 100; ++i) {
    LightParameters d;
    d.type = LightType::sphere;
    d.intensity = i == 70 ? 50.0f : 1.0f;
    d.light_to_world[3][0] = i % 2 == 0 ? -100 : 100;
    d.light_to_world[3][1] = i;
    lights.push_back(make_light(d, Vec3d(0, 0, 0)));
  }
  const LightTree tree(lights);
  float near = 0;
  for (size_t i = 0; i < 100; i += 2) near += tree.probability(lights, {-60, 50, 0}, i);
  EXPECT_GT(near, 0.8f);
  EXPECT_GT(tree.probability(lights, {-60, 50, 0}, 70), 0.3f);
}

// Two groups at one distance, of lights that face the point or nearly so, and of others that face away.
TEST(LightTree, PrefersGroupsThatFaceThePoint) {
  for (const LightType type : {LightType::disk, LightType::sphere}) {
    Rng rng(8, 1);
    std::vector<Light> lights;
    for (int i = 0; i < 128; ++i) {
      LightParameters d;
      d.type = type;
      d.radius = 0.01f;
      if (type == LightType::sphere) d.cone_angle = 50;
      const double side = i % 2 == 0 ? -10 : 10, tilt = 0.4 * (static_cast<double>(rng.uniform()) - 0.5);
      const Vec3d place(random_point(rng, 0.5f));
      d.light_to_world = Matrix4d(std::cos(tilt), 0, -std::sin(tilt), 0, 0, 1, 0, 0, std::sin(tilt), 0, std::cos(tilt),
                                  0, side + place.x, place.y, side + place.z, 1);
      lights.push_back(make_light(d, Vec3d(0, 0, 0)));  // down -z
    }
    const LightTree tree(lights);
    float facing = 0, averted = 0;
    for (size_t i = 0; i < lights.size(); ++i)
      (i % 2 == 1 ? facing : averted) += tree.probability(lights, {10, 0, 0}, i);
    EXPECT_GT(facing, 0.94f);
    EXPECT_GT(averted, 0.04f) << "the reserved share";
    EXPECT_GT(tree.probability(lights, {0, 0, 0}, 1), 0);
  }
}

TEST(LightTree, ScalingByAPowerOfTwoChangesNoBit) {
  const auto lights = many_lights(100), large = many_lights(100, 1024);
  const LightTree tree(lights), large_tree(large);
  Rng rng(3, 2);
  for (int k = 0; k < 50; ++k) {
    const Vec3f p = random_point(rng, 12);
    for (size_t i = 0; i < lights.size(); ++i) {
      EXPECT_EQ(tree.probability(lights, p, i), large_tree.probability(large, p * 1024, i));
    }
  }
}

}  // namespace
}  // namespace alabaster
