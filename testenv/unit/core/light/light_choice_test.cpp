#include "core/light/light_choice.h"

#include <gtest/gtest.h>

#include "core/sampling/pixel_sampler.h"

namespace alabaster {
namespace {

const std::vector<LobeScales> kUnscaled;

Light described(LightType type, float intensity, double scale = 1) {
  LightParameters d;
  d.type = type;
  d.intensity = intensity;
  d.angle = 180;  // of a distant light: it gives pi times its radiance on a plane that faces it
  for (int i = 0; i < 3; ++i) d.light_to_world[i][i] = scale;
  d.light_to_world[3][2] = 2 * scale;
  if (type == LightType::rect) return RectDiskLight(d, Vec3d(0, 0, 0));
  if (type == LightType::sphere) return SphereLight(d, Vec3d(0, 0, 0));
  if (type == LightType::distant) return DistantLight(d, Vec3d(0, 0, 0));
  return DomeLight(d, Vec3d(0, 0, 0));
}

std::vector<Light> mixed(double scale = 1) {
  const auto s = static_cast<float>(scale);
  return {described(LightType::rect, 5, scale),
          described(LightType::sphere, 0, scale),
          described(LightType::sphere, 2, scale),
          described(LightType::distant, 0.1f, scale),
          MeshLight(0, {{{0, 0, -s}, {s, 0, -s}, {0, s, 0}, Rgb(3.0f)}}, {0}),
          described(LightType::dome, 0.1f, scale)};
}

std::vector<float> probabilities(const std::vector<Light>& lights, const Vec3f& p) {
  LightChoice choice(lights, kUnscaled, p);
  std::vector<float> result;
  for (size_t i = 0; i < lights.size(); ++i) result.push_back(choice.probability(i));
  return result;
}

Vec3f random_point(Rng& rng) {
  const float x = rng.uniform(), y = rng.uniform();
  return {8 * x - 4, 8 * y - 4, 8 * rng.uniform() - 4};
}

double importance(const Light& light, const Vec3f& p) {
  return std::visit([&](const auto& l) { return l.importance(p); }, light);
}

// Multiples of 2^-24: their sum is exact in double.
TEST(LightChoice, ProbabilitiesAreTheMixtureAndSumToOne) {
  const auto lights = mixed();
  Rng rng(1, 1);
  int behind_the_rect = 0;
  for (int k = 0; k < 2000; ++k) {
    const Vec3f p = random_point(rng);
    double total = 0, sum = 0, shining = 0;
    for (const Light& light : lights) {
      if (is_constant_dome(light)) continue;
      total += importance(light, p);
      shining += importance(light, p) > 0 ? 1 : 0;
    }
    const auto probability = probabilities(lights, p);
    LightChoice backwards(lights, kUnscaled, p);
    for (size_t i = 0; i < lights.size(); ++i) {
      const double w = is_constant_dome(lights[i]) ? 0 : importance(lights[i], p);
      EXPECT_NEAR(probability[i], w > 0 ? 0.9 * w / total + 0.1 / shining : 0, 0x1p-23);
      EXPECT_EQ(probability[i] > 0, w > 0);
      EXPECT_EQ(LightChoice(lights, kUnscaled, p).probability(i), probability[i]) << "asked alone";
      EXPECT_EQ(backwards.probability(lights.size() - 1 - i), probability[lights.size() - 1 - i]);
      sum += static_cast<double>(probability[i]);
    }
    EXPECT_EQ(sum, 1);
    EXPECT_EQ(probability[1], 0) << "the dark sphere";
    behind_the_rect += probability[0] == 0 ? 1 : 0;
  }
  EXPECT_GT(behind_the_rect, 100);
}

// More lights than the importances that are kept, and emissions at the ends of the floats.
TEST(LightChoice, ManyAndExtremeLights) {
  std::vector<Light> lights;
  for (int i = 0; i < 500; ++i)
    lights.push_back(described(i % 2 == 0 ? LightType::sphere : LightType::distant, i % 3 == 0 ? 1e-38f : 3e38f));
  for (const Vec3f& p : {Vec3f(0, 0, 0), Vec3f(1e30f, 0, 0), Vec3f(0, 0, 2)}) {
    double sum = 0;
    for (const float probability : probabilities(lights, p)) {
      EXPECT_GE(probability, 0.1f / 500 - 0x1p-23f);
      sum += static_cast<double>(probability);
    }
    EXPECT_EQ(sum, 1);
    for (float u : {0.0f, 0.7f, kOneMinusEpsilon}) EXPECT_TRUE(LightChoice(lights, kUnscaled, p).choose(u));
  }
}

// All lengths times 2^k: the same choice to the last bit.
TEST(LightChoice, DoesNotDependOnTheUnitOfLength) {
  const auto lights = mixed();
  for (int k : {-40, -7, 13, 40}) {
    const auto scaled = mixed(std::ldexp(1.0, k));
    Rng rng(2, 1);
    for (int i = 0; i < 500; ++i) {
      const Vec3f p = random_point(rng);
      EXPECT_EQ(probabilities(lights, p), probabilities(scaled, p * std::ldexp(1.0f, k)));
    }
  }
}

}  // namespace
}  // namespace alabaster
