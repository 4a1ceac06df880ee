#include "core/material/disney_bsdf.h"

#include <gtest/gtest.h>

#include <array>
#include <numeric>

#include "core/sampling/warp.h"
#include "testenv/support/chi_square.h"
#include "testenv/support/disney_reference.h"
#include "testenv/support/extreme_numbers.h"
#include "testenv/support/material_testing.h"
#include "testenv/support/z_test.h"

namespace alabaster {
namespace {

using testing::color_or_extreme;
using testing::uniform2;
using testing::unit_or_extreme;

DisneyParameters random_parameters(Rng& rng) {
  DisneyParameters p;
  p.base_color = color_or_extreme(rng);
  p.metallic = unit_or_extreme(rng);
  p.roughness = unit_or_extreme(rng);
  p.anisotropic = unit_or_extreme(rng);
  p.specular_tint = unit_or_extreme(rng);
  p.ior = 1 + 3 * unit_or_extreme(rng);
  p.specular = unit_or_extreme(rng);
  p.specular_color = color_or_extreme(rng) * (rng.next() % 8 == 0 ? 1e30f : 1);
  p.sheen = unit_or_extreme(rng);
  p.sheen_tint = unit_or_extreme(rng);
  p.clearcoat = unit_or_extreme(rng);
  p.clearcoat_gloss = unit_or_extreme(rng);
  if (rng.next() % 2) p.scatter_distance = color_or_extreme(rng);
  if (rng.next() % 4 == 0) p.coat = unit_or_extreme(rng);
  p.coat_roughness = unit_or_extreme(rng);
  p.coat_ior = 1 + 3 * unit_or_extreme(rng);
  p.coat_color = color_or_extreme(rng);
  p.coat_darkening = unit_or_extreme(rng);
  if (rng.next() % 4 == 0) p.sheen_roughness = unit_or_extreme(rng);
  return p;
}

/// Above the horizon, often far down, seldom in the plane of the horizon's last float.
Vec3f random_direction(Rng& rng) {
  constexpr float kHeights[] = {1, 1e-1f, 1e-3f, 1e-6f, 1e-12f, 1e-30f, 1e-44f};
  const uint32_t pick = rng.next() % 14;
  if (pick >= 7) return sample_cosine_hemisphere(uniform2(rng));
  const float z = kHeights[pick], r = safe_sqrt(1 - z * z), phi = kTwoPi * rng.uniform();
  return {r * std::cos(phi), r * std::sin(phi), z};
}

bool is_valid(const Rgb& f) {
  return is_finite(f) && f.r >= 0 && f.g >= 0 && f.b >= 0;
}

TEST(DisneyBsdf, FuzzIsFiniteNonNegativeAndBounded) {
  Rng rng(testing::run_seed(2024), 1);
  float heaviest = 0;
  int samples = 0;
  for (int i = 0; i < 100000; ++i) {
    const DisneyParameters p = random_parameters(rng);
    const Vec3f wo = random_direction(rng);
    const DisneyBsdf bsdf(p, wo);
    Vec3f wi = random_direction(rng);
    // The mirror direction and the way back are where lobes peak or lose their half vector.
    if (i % 8 == 0) wi = {-wo.x, -wo.y, wo.z};
    if (i % 8 == 1) wi = wo;
    const auto [f_cos, pdf] = bsdf.evaluate(wi);
    ASSERT_TRUE(is_valid(f_cos)) << i;
    ASSERT_TRUE(std::isfinite(pdf) && pdf >= 0) << i;
    ASSERT_TRUE(is_valid(bsdf.albedo()) && max_component(bsdf.albedo()) <= 1) << i;
    ASSERT_TRUE(is_valid(bsdf.subsurface_entry()) && max_component(bsdf.subsurface_entry()) <= 1) << i;
    // A direction that light can come from can be sampled, where the cosine's density does not underflow.
    ASSERT_TRUE(pdf > 0 || wi.z < 1e-20f || is_black(f_cos)) << i;

    const float u_lobe = i % 16 == 0 ? kOneMinusEpsilon : rng.uniform();
    const Vec2f u = i % 16 == 1 ? Vec2f(kOneMinusEpsilon, kOneMinusEpsilon) : i % 16 == 2 ? Vec2f(0, 0) : uniform2(rng);
    Rgb specular, evaluated_specular;
    const auto sample = bsdf.sample(u_lobe, u, &specular);
    if (!sample) continue;
    ++samples;
    ASSERT_TRUE(is_valid(sample->f_cos)) << i;
    ASSERT_TRUE(std::isfinite(sample->pdf) && sample->pdf > 0) << i;
    heaviest = std::max(heaviest, max_component(sample->weight()));
    if (sample->lobe == Lobe::subsurface) continue;
    ASSERT_NEAR(length(sample->wi), 1, 1e-5) << i;
    ASSERT_GT(sample->wi.z, 0) << i;
    const BsdfValue value = bsdf.evaluate(sample->wi, &evaluated_specular);
    ASSERT_EQ(sample->f_cos, value.f_cos) << i;
    ASSERT_EQ(sample->pdf, value.pdf) << i;
    ASSERT_EQ(specular, evaluated_specular) << i;
  }
  std::cout << "heaviest sample weight " << heaviest << " of " << samples << "\n";
  EXPECT_GT(samples, 80000);
  // f cos / pdf of one lobe is at most 36 times its albedo estimate (sheen, seen at 60 degrees), times 3 between the
  // mean and one channel, times the sum of the estimates, at most 2.3 here (sheen of pure blue: 0.088 * 10 / 3).
  EXPECT_LT(heaviest, 36 * 3 * 2.3f);
}

TEST(DisneyBsdf, DiffuseRoughnessIsThatOfTheRetroReflectionAlone) {
  DisneyParameters smooth, rough;
  smooth.roughness = 0.2f, smooth.diffuse_roughness = 0.7f;
  rough.roughness = 0.7f;
  const Vec3f wo = normalize(Vec3f(0.8f, 0.1f, 0.5f));
  for (const Vec3f& at : {Vec3f(0.7f, 0, 0.3f), Vec3f(-0.5f, 0.4f, 0.4f), Vec3f(0, 0, 1)}) {
    const Vec3f wi = normalize(at);
    Rgb of_smooth, of_rough;
    const Rgb a = DisneyBsdf(smooth, wo).evaluate(wi, &of_smooth).f_cos;
    const Rgb b = DisneyBsdf(rough, wo).evaluate(wi, &of_rough).f_cos;
    EXPECT_NEAR(a.g - of_smooth.g, b.g - of_rough.g, 1e-6);
    EXPECT_GT(std::abs(of_smooth.g - of_rough.g), 1e-3 * double(of_rough.g));
  }
}

TEST(DisneyBsdf, NothingBelowTheHorizon) {
  DisneyParameters p;
  p.clearcoat = p.sheen = 1;
  p.scatter_distance = {1, 0, 0};
  for (const Vec3f& wo : {Vec3f(0, 0, -1), Vec3f(1, 0, 0), Vec3f(0.8f, 0, -0.6f)}) {
    const DisneyBsdf bsdf(p, wo);
    EXPECT_TRUE(is_black(bsdf.evaluate({0, 0, 1}).f_cos));
    EXPECT_EQ(bsdf.evaluate({0, 0, 1}).pdf, 0);
    EXPECT_FALSE(bsdf.sample(0.3f, {0.4f, 0.6f}).has_value());
    EXPECT_TRUE(is_black(bsdf.subsurface_entry()));
  }
  const DisneyBsdf bsdf(p, {0, 0.6f, 0.8f});
  for (const Vec3f& wi : {Vec3f(0, 0, -1), Vec3f(0, 1, 0), Vec3f(0, 0.8f, -0.6f)}) {
    EXPECT_TRUE(is_black(bsdf.evaluate(wi).f_cos));
    EXPECT_EQ(bsdf.evaluate(wi).pdf, 0);
    EXPECT_EQ(subsurface_exit_f_cos(wi.z), 0);
  }
}

TEST(DisneyBsdf, ABlackSurfaceOfIorOneAbsorbsEverything) {
  DisneyParameters p;
  p.base_color = Rgb(0.0f);
  p.ior = 1;
  const DisneyBsdf bsdf(p, {0, 0, 1});
  EXPECT_TRUE(is_black(bsdf.evaluate(normalize(Vec3f(1, 0, 1))).f_cos));
  EXPECT_FALSE(bsdf.sample(0.5f, {0.5f, 0.5f}).has_value());
}

TEST(DisneyBsdf, SpecularPartIsThatOfSpecularAndClearcoat) {
  Rng rng(testing::run_seed(23), 4);
  int shared = 0;
  for (int i = 0; i < 20000; ++i) {
    DisneyParameters p = random_parameters(rng);
    p.coat = p.sheen_roughness = 0;
    const Vec3f wo = random_direction(rng), wi = random_direction(rng);
    const DisneyBsdf bsdf(p, wo);
    Rgb part;
    const Rgb all = bsdf.evaluate(wi, &part).f_cos;
    ASSERT_EQ(bsdf.evaluate(wi).f_cos, all) << "whether it is asked for or not";
    const Rgb glossy = (DisneySpecular::from(p).evaluate(wo, wi).f +
                        DisneyClearcoat::from(p.clearcoat, p.clearcoat_gloss).evaluate(wo, wi).f) *
                       std::max(0.0f, wi.z);
    for (int c = 0; c < 3; ++c) {
      ASSERT_TRUE(part[c] >= 0 && part[c] <= all[c]) << i;
      ASSERT_NEAR(part[c], glossy[c], 1e-6f * all[c]) << i;
      shared += part[c] > 0.01f * all[c] && part[c] < 0.99f * all[c];
    }
  }
  EXPECT_GT(shared, 10000) << "both kinds of lobe were at work";
}

// Each channel on its own: a channel that does not scatter is the plain diffuse to the last bit, one that does is the
// plain one less its first term.
TEST(DisneyBsdf, ScatterDistanceTakesTheLambertTermOfItsChannelOnly) {
  Rng rng(testing::run_seed(17), 2);
  for (int i = 0; i < 20000; ++i) {
    DisneyParameters plain = random_parameters(rng);
    plain.scatter_distance = Rgb(0.0f);
    plain.coat = plain.sheen_roughness = 0;
    DisneyParameters mixed = plain;
    for (int c = 0; c < 3; ++c) mixed.scatter_distance[c] = rng.next() % 2 ? 0.0f : 1e-12f + rng.uniform();
    const Vec3f wo = random_direction(rng), wi = random_direction(rng);
    const DisneyBsdf a(plain, wo), b(mixed, wo);
    const Rgb fa = a.evaluate(wi).f_cos, fb = b.evaluate(wi).f_cos;
    const float lambert = (1 - plain.metallic) * DisneyDiffuse::lambert(wo, wi) * wi.z;
    for (int c = 0; c < 3; ++c) {
      const bool scatters = mixed.scatter_distance[c] > 0;
      if (!scatters) {
        ASSERT_EQ(fa[c], fb[c]) << i;
        ASSERT_EQ(b.subsurface_entry()[c], 0) << i;
      } else {
        const float taken = plain.base_color[c] * lambert;
        ASSERT_NEAR(fa[c] - fb[c], taken, 1e-6f * std::max(1.0f, fa[c])) << i;
        const float entry = (1 - plain.metallic) * (1 - 0.5f * schlick_weight(wo.z));
        ASSERT_FLOAT_EQ(b.subsurface_entry()[c], entry) << i;
      }
    }
  }
}

double relative(double a, double b) {
  return std::abs(a - b) / std::max(std::abs(b), 1e-12);
}

// Against formulas written a second time, in double and in angles.
TEST(DisneyBsdf, MatchesIndependentReference) {
  Rng rng(testing::run_seed(99), 4);
  double worst = 0;
  for (int i = 0; i < 20000; ++i) {
    DisneyParameters p;
    p.base_color = {rng.uniform(), rng.uniform(), rng.uniform()};
    p.metallic = rng.uniform();
    p.roughness = 0.1f + 0.9f * rng.uniform();
    p.anisotropic = 0.9f * rng.uniform();
    p.specular_tint = rng.uniform();
    p.ior = 1.35f + rng.uniform();
    p.sheen = rng.uniform();
    p.sheen_tint = rng.uniform();
    p.clearcoat = rng.uniform();
    p.clearcoat_gloss = 0.9f * rng.uniform();
    const Vec3f wo = sample_cosine_hemisphere(uniform2(rng)), wi = sample_cosine_hemisphere(uniform2(rng));
    if (wo.z < 0.01f || wi.z < 0.01f || dot(wo, wi) < -0.99f) continue;
    // Tinted f0 above one is cut off by ours, not in the paper, which has no such colours.
    const auto& c = p.base_color;
    testing::ReferenceParameters r;
    r.base_color = {double(c.r), double(c.g), double(c.b)};
    r.metallic = double(p.metallic);
    r.roughness = double(p.roughness);
    r.anisotropic = double(p.anisotropic);
    r.specular_tint = double(p.specular_tint);
    r.ior = double(p.ior);
    r.sheen = double(p.sheen);
    r.sheen_tint = double(p.sheen_tint);
    r.clearcoat = double(p.clearcoat);
    r.clearcoat_gloss = double(p.clearcoat_gloss);
    const auto f0 = double(f0_from_ior(p.ior)) * double(max_component(tint(c)));
    if (f0 > 1) continue;
    const auto terms = testing::disney_reference_2012(r, normalize(Vec3d(wo)), normalize(Vec3d(wi)));
    const Rgb f = testing::f_of(DisneyBsdf(p, wo).evaluate(wi), wi);
    for (int k = 0; k < 3; ++k) {
      const auto j = static_cast<size_t>(k);
      const double expected = terms.diffuse[j] + terms.sheen[j] + terms.specular[j] + terms.clearcoat;
      worst = std::max(worst, relative(double(f[k]), expected));
    }
  }
  std::cout << "worst relative difference " << worst << "\n";
  EXPECT_LT(worst, 2e-4);
}

// f(wo, wi) = f(wi, wo), lobe by lobe and together.
TEST(DisneyBsdf, Reciprocity) {
  Rng rng(testing::run_seed(8), 8);
  const auto expect_equal = [](const Rgb& a, const Rgb& b, int i) {
    for (int c = 0; c < 3; ++c) ASSERT_LE(relative(double(a[c]), double(b[c])), 2e-5) << i;
  };
  for (int i = 0; i < 20000; ++i) {
    const DisneyParameters p = random_parameters(rng);
    const Vec3f wo = sample_cosine_hemisphere(uniform2(rng)), wi = sample_cosine_hemisphere(uniform2(rng));
    if (wo.z < 1e-3f || wi.z < 1e-3f) continue;
    const DisneyDiffuse diffuse{Rgb(0.3f), p.base_color, p.roughness};
    expect_equal(diffuse.evaluate(wo, wi).f, diffuse.evaluate(wi, wo).f, i);
    const DisneySheen sheen{p.base_color};
    expect_equal(sheen.evaluate(wo, wi).f, sheen.evaluate(wi, wo).f, i);
    const DisneySpecular specular = DisneySpecular::from(p);
    expect_equal(specular.evaluate(wo, wi).f, specular.evaluate(wi, wo).f, i);
    const DisneyClearcoat coat = DisneyClearcoat::from(p.clearcoat, p.clearcoat_gloss);
    expect_equal(coat.evaluate(wo, wi).f, coat.evaluate(wi, wo).f, i);
    for (const EnergyModel energy : {EnergyModel::burley2015, EnergyModel::bounded, EnergyModel::conserving})
      expect_equal(testing::f_of(DisneyBsdf(p, wo, energy).evaluate(wi), wi),
                   testing::f_of(DisneyBsdf(p, wi, energy).evaluate(wo), wo), i);
  }
}

}  // namespace
}  // namespace alabaster
