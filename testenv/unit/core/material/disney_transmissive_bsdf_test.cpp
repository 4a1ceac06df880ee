#include "core/material/disney_transmissive_bsdf.h"

#include <gtest/gtest.h>

#include <array>

#include "testenv/support/chi_square.h"
#include "testenv/support/extreme_numbers.h"
#include "testenv/support/material_testing.h"

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
  p.ior = 1 + 3 * unit_or_extreme(rng);
  p.specular = unit_or_extreme(rng);
  p.specular_color = color_or_extreme(rng);
  p.clearcoat = unit_or_extreme(rng);
  if (rng.next() % 2) p.coat = unit_or_extreme(rng), p.coat_roughness = unit_or_extreme(rng);
  p.coat_ior = 1 + 3 * unit_or_extreme(rng), p.coat_color = color_or_extreme(rng);
  p.coat_darkening = unit_or_extreme(rng);
  if (rng.next() % 2) p.iridescence = unit_or_extreme(rng), p.iridescence_thickness = 1000 * rng.uniform();
  p.sheen = unit_or_extreme(rng);
  p.spec_trans = unit_or_extreme(rng);
  p.diff_trans = 2 * unit_or_extreme(rng);
  p.thin = rng.next() % 2;
  p.flatness = unit_or_extreme(rng);
  if (rng.next() % 2) p.scatter_distance = color_or_extreme(rng);
  return p;
}

Vec3f below(const Vec3f& w) {
  return {w.x, w.y, -w.z};
}

TEST(TransparentSheet, ItsClearSharePassesStraightAndUntintedBelowTheFullHighlight) {
  DisneyParameters opaque;
  opaque.base_color = {0.9f, 0.2f, 0.1f};
  opaque.roughness = 0.1f;
  DisneyParameters sheet = opaque;
  sheet.opacity_mode = OpacityMode::transparent, sheet.thin = true, sheet.spec_trans = 0.7f;
  for (const float degrees : {0.0f, 40.0f, 70.0f}) {
    const float theta = degrees * kPi / 180;
    const Vec3f wo(std::sin(theta), 0, std::cos(theta)), mirrored(-wo.x, 0, wo.z);
    const DisneyTransmissiveBsdf bsdf(sheet, wo, {1.5f, false}, EnergyModel::bounded);
    Rgb highlight, of_opaque;
    const Rgb all = bsdf.evaluate(mirrored, &highlight).f_cos;
    const Rgb whole = DisneyBsdf(opaque, wo, EnergyModel::bounded).evaluate(mirrored, &of_opaque).f_cos;
    EXPECT_EQ(highlight, of_opaque);
    EXPECT_NEAR(all.r - highlight.r, 0.3f * (whole.r - of_opaque.r), 0.03f * (whole.r - of_opaque.r) + 1e-5f);
    const Rgb passed = bsdf.straight();
    EXPECT_NEAR(passed.g, 0.7f * (1 - lerp(0.04f, 1.0f, schlick_weight(wo.z))), 0.004f) << degrees;
    EXPECT_EQ(passed, Rgb(passed.g));
    EXPECT_FALSE(bsdf.scatters_beyond());
  }
}

// The share that is no metal passes what its own highlight leaves.
TEST(TransparentSheet, AHalfMetalPassesTheHalfThatIsNone) {
  for (const EnergyModel energy : {EnergyModel::burley2015, EnergyModel::bounded, EnergyModel::conserving})
    for (const float roughness : {0.1f, 0.8f}) {
      DisneyParameters sheet;
      sheet.base_color = {0.9f, 0.2f, 0.1f};
      sheet.roughness = roughness;
      sheet.opacity_mode = OpacityMode::transparent, sheet.thin = true, sheet.spec_trans = 0.7f;
      const Vec3f wo(0.6f, 0, 0.8f);
      const Rgb whole = DisneyTransmissiveBsdf(sheet, wo, {1.5f, false}, energy).straight();
      sheet.metallic = 0.5f;
      const Rgb half = DisneyTransmissiveBsdf(sheet, wo, {1.5f, false}, energy).straight();
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(half[c], 0.5f * whole[c], 1e-3f) << roughness;
    }
}

TEST(FresnelDielectric, KnownValues) {
  EXPECT_NEAR(fresnel_dielectric(1, 1.5f), 0.04f, 1e-7f);
  EXPECT_NEAR(fresnel_dielectric(1, 1 / 1.5f), 0.04f, 1e-7f) << "the same from either side";
  // At Brewster's angle, tan = eta, one polarisation is not reflected; the other by ((eta^2 - 1) / (eta^2 + 1))^2.
  const float brewster = 1 / std::sqrt(1 + 1.5f * 1.5f);
  EXPECT_NEAR(fresnel_dielectric(brewster, 1.5f), 0.5f * sqr(1.25f / 3.25f), 1e-6f);
  const float critical = std::sqrt(1 - 1 / (1.5f * 1.5f));
  EXPECT_EQ(fresnel_dielectric(critical - 1e-3f, 1 / 1.5f), 1);
  EXPECT_LT(fresnel_dielectric(critical + 1e-3f, 1 / 1.5f), 0.9f);
  EXPECT_LT(fresnel_dielectric(0.3f, 1), 1e-12f);
  EXPECT_NEAR(fresnel_dielectric(1e-6f, 1.5f), 1, 1e-4f);
}

// f(wo, wi) / n_o^2 = f(wi, wo) / n_i^2, where n are the indices of the media that the directions lie in; each function
// is of a viewer in the upper half of its own frame.
TEST(DisneyTransmissiveBsdf, Reciprocity) {
  Rng rng(17, 3);
  int compared = 0;
  for (int i = 0; i < 40000; ++i) {
    DisneyParameters p = random_parameters(rng);
    p.roughness = 0.1f + 0.9f * p.roughness;
    p.clearcoat = p.sheen = p.coat = p.iridescence = 0;  // on one side of a solid
    const float eta = p.thin ? p.ior : 1.05f + 0.9f * rng.uniform();
    const Vec3f wo = sample_cosine_hemisphere(uniform2(rng)), wi = sample_cosine_hemisphere(uniform2(rng));
    if (wo.z < 1e-2f || wi.z < 1e-2f) continue;
    const InterfaceSide outside{eta, false}, inside{p.thin ? eta : 1 / eta, !p.thin};
    const DisneyTransmissiveBsdf from_o(p, wo, outside);
    const auto f = [](const DisneyTransmissiveBsdf& bsdf, const Vec3f& w) {
      return testing::f_of(bsdf.evaluate(w), w);
    };
    const Rgb reflected = f(from_o, wi), reflected_back = f(DisneyTransmissiveBsdf(p, wi, outside), wo);
    // The surface turned over: both directions upside down.
    const Rgb passed = f(from_o, below(wi)), back = f(DisneyTransmissiveBsdf(p, wi, inside), below(wo));
    const float n2 = p.thin ? 1 : eta * eta;
    const bool diffuse = p.diff_trans > 0 && p.spec_trans < 1 && p.metallic < 1;  // its f knows no index
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(reflected[c], reflected_back[c], 1e-4f * reflected[c] + 1e-6f) << i;
      if (diffuse) continue;
      EXPECT_NEAR(passed[c] * n2, back[c], 2e-3f * back[c] + 1e-6f) << i;
      compared += back[c] > 0;
    }
  }
  EXPECT_GT(compared, 3000);
}

TEST(DisneyTransmissiveBsdf, FuzzIsFiniteNonNegativeAndBounded) {
  Rng rng(2025, 1);
  double heaviest = 0;
  int crossed = 0;
  for (int i = 0; i < 100000; ++i) {
    const DisneyParameters p = random_parameters(rng);
    const bool is_inside = rng.next() % 2;
    const float eta = rng.next() % 8 == 0 ? 1 : is_inside ? 1 / p.ior : p.ior;
    const Vec3f wo = sample_cosine_hemisphere(uniform2(rng));
    const DisneyTransmissiveBsdf bsdf(p, wo, {eta, is_inside});
    Vec3f wi = sample_cosine_hemisphere(uniform2(rng));
    if (i % 2) wi.z = -wi.z;
    if (i % 8 == 0) wi = {-wo.x, -wo.y, wo.z};
    if (i % 8 == 1) wi = -wo;
    Rgb specular;
    const auto [f_cos, pdf] = bsdf.evaluate(wi, &specular);
    for (int c = 0; c < 3; ++c) {
      ASSERT_TRUE(std::isfinite(f_cos[c]) && f_cos[c] >= 0) << i;
      ASSERT_TRUE(specular[c] >= 0 && specular[c] <= f_cos[c]) << i;
    }
    ASSERT_TRUE(std::isfinite(pdf) && pdf >= 0) << i;
    const float u_lobe = i % 16 == 0 ? kOneMinusEpsilon : rng.uniform();
    const auto sample = bsdf.sample(u_lobe, uniform2(rng));
    if (!sample) continue;
    ASSERT_TRUE(is_finite(sample->f_cos) && std::isfinite(sample->pdf) && sample->pdf > 0) << i;
    if (sample->lobe == Lobe::subsurface) continue;
    ASSERT_NEAR(length(sample->wi), 1, 1e-5) << i;
    if (sample->lobe == Lobe::straight) {
      ASSERT_EQ(sample->wi, -wo);
      continue;
    }
    const BsdfValue value = bsdf.evaluate(sample->wi);
    ASSERT_EQ(sample->f_cos, value.f_cos) << i;
    ASSERT_EQ(sample->pdf, value.pdf) << i;
    crossed += sample->wi.z < 0;
    // Radiance in the far medium is eta^2 times as large.
    const double scale = sample->wi.z < 0 && !p.thin ? double(eta) * double(eta) : 1;
    heaviest = std::max(heaviest, double(max_component(sample->weight())) * scale);
  }
  std::cout << "heaviest sample weight " << heaviest << ", " << crossed << " crossed\n";
  EXPECT_GT(crossed, 20000);
  EXPECT_LT(heaviest, 60);
}

// Index 1 on both sides: all light goes straight on, with weight one.
TEST(DisneyTransmissiveBsdf, IorOneDoesNothing) {
  DisneyParameters p;
  p.base_color = Rgb(1.0f);
  p.ior = p.spec_trans = 1;
  for (const float roughness : {0.0f, 0.5f, 1.0f})
    for (const bool thin : {false, true}) {
      p.roughness = roughness;
      p.thin = thin;
      const Vec3f wo = normalize(Vec3f(0.3f, 0.4f, 0.6f));
      const DisneyTransmissiveBsdf bsdf(p, wo, {1, false});
      EXPECT_FALSE(bsdf.scatters_beyond());
      Rng rng(1, 1);
      for (int i = 0; i < 1000; ++i) {
        const float u_lobe = rng.uniform();
        const auto sample = bsdf.sample(u_lobe, uniform2(rng));
        ASSERT_TRUE(sample);
        EXPECT_EQ(sample->lobe, Lobe::straight);
        EXPECT_EQ(sample->wi, -wo);
        EXPECT_EQ(sample->f_cos, Rgb(1.0f));
        EXPECT_EQ(sample->pdf, 1);
      }
      EXPECT_TRUE(is_black(bsdf.evaluate(-wo).f_cos) && is_black(bsdf.evaluate({-wo.x, -wo.y, wo.z}).f_cos));
    }
}

// Two faces, and all orders of the light between them.
TEST(DisneyThinDielectric, ASmoothSheetIsItsClosedForm) {
  DisneyParameters p;
  p.base_color = {0.9f, 0.5f, 0.1f};
  p.spec_trans = 1;
  p.thin = true;
  p.roughness = 0;
  for (const float cosine : {1.0f, 0.7f, 0.2f}) {
    const Vec3f wo(std::sqrt(1 - cosine * cosine), 0, cosine);
    const DisneyTransmissiveBsdf bsdf(p, wo, {1.5f, false});
    const float fresnel = fresnel_dielectric(cosine, 1.5f);
    Rng rng(4, 4);
    Rgb reflected(0.0f), passed(0.0f);
    constexpr int kSamples = 20000;
    for (int i = 0; i < kSamples; ++i) {
      const float u_lobe = rng.uniform();
      const auto s = bsdf.sample(u_lobe, uniform2(rng));
      ASSERT_TRUE(s);
      const bool straight = s->lobe == Lobe::straight;
      (straight ? passed : reflected) += s->weight() * (1 / static_cast<float>(kSamples));
    }
    for (int c = 0; c < 3; ++c) {
      const float through = (1 - fresnel) / (1 + fresnel) * p.base_color[c];
      EXPECT_NEAR(passed[c], through, 0.03f * through);
      EXPECT_NEAR(reflected[c], fresnel * (1 + through), 0.03f * reflected[c] + 0.002f);
    }
  }
}

TEST(DisneyThinDielectric, RoughnessThrough) {
  EXPECT_FLOAT_EQ(DisneyThinDielectric::roughness_through(0.8f, 1.5f), 0.8f * 0.625f);
  EXPECT_EQ(DisneyThinDielectric::roughness_through(0.8f, 1), 0);
  EXPECT_EQ(DisneyThinDielectric::roughness_through(0.8f, 4), 0.8f);
}

// Burley 2012's subsurface approximation, from the published code in double precision; the most that white reflects.
TEST(DisneyDiffuse, FlatnessIsThePublishedApproximation) {
  Rng rng(3, 9);
  for (int i = 0; i < 10000; ++i) {
    const Vec3f wo = sample_cosine_hemisphere(uniform2(rng)), wi = sample_cosine_hemisphere(uniform2(rng));
    const float roughness = rng.uniform();
    const auto fresnel = [](float cosine) { return std::pow(1 - double(cosine), 5); };
    const Vec3d h = normalize(Vec3d(wo + wi));
    const double cos_d = dot(Vec3d(wi), h), f90 = cos_d * cos_d * double(roughness);
    const double f = (1 + (f90 - 1) * fresnel(wi.z)) * (1 + (f90 - 1) * fresnel(wo.z));
    const double expected = 1.25 * (f * (1 / (double(wi.z) + double(wo.z)) - 0.5) + 0.5) / M_PI;
    EXPECT_NEAR(DisneyDiffuse::flat(wo, wi, roughness), expected, 1e-4 * expected);
  }
  for (const float cosine : {1.0f, 0.5f, 0.1f}) {
    const Vec3f wo(std::sqrt(1 - cosine * cosine), 0, cosine);
    for (const float roughness : {0.0f, 1.0f}) {
      const auto f = [&](const Vec3f& wi) {
        return wi.z > 0 ? double(DisneyDiffuse::flat(wo, wi, roughness) * wi.z) : 0.0;
      };
      const double albedo = testing::integrate_sphere(f, {}, 1);
      std::cout << "flat, cosine " << cosine << " roughness " << roughness << ": " << albedo << "\n";
      EXPECT_LT(albedo, roughness > 0 ? 1.6 : 1.1);
    }
  }
}

// The film of KHR_materials_iridescence: none where it has no thickness, colours that the thickness moves, the same
// light either way, never more than all of it.
TEST(ThinFilm, Interferes) {
  const Rgb f0(0.04f);
  const Rgb none = ThinFilm{1, 1.3f, 0}.reflectance(1, f0);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(none[c], 0.04f, 2e-3f) << "no film";
  // A quarter of a wave of green, 550 nm, between air and glass: the two reflections cancel where the film's index is
  // the root of the glass's, and add up to that of the bare glass where it is half a wave.
  const float n = std::sqrt(1.5f);
  const Rgb quarter = ThinFilm{1, n, 550 / (4 * n)}.reflectance(1, f0);
  EXPECT_LT(quarter.g, 0.006f);
  const Rgb half = ThinFilm{1, n, 550 / (2 * n)}.reflectance(1, f0);
  EXPECT_NEAR(half.g, 0.04f, 0.01f);
  Rng rng(6, 6);
  float most_colored = 0;
  for (int i = 0; i < 20000; ++i) {
    const Rgb base(rng.uniform(), rng.uniform(), rng.uniform());
    const Rgb r = ThinFilm{1, 1 + 2 * rng.uniform(), 1200 * rng.uniform()}.reflectance(rng.uniform(), base);
    for (int c = 0; c < 3; ++c) ASSERT_TRUE(r[c] >= 0 && r[c] <= 1);
    most_colored = std::max(most_colored, std::abs(r.r - r.b) - std::abs(base.r - base.b));
  }
  EXPECT_GT(most_colored, 0.2f);
}

TEST(DisneyTransmissiveBsdf, ShareOfEachPart) {
  DisneyParameters p;
  p.base_color = Rgb(1.0f);
  p.scatter_distance = Rgb(1.0f);
  p.spec_trans = 0.25f;
  p.diff_trans = 0.5f;
  p.metallic = 0.5f;
  const Vec3f wo(0, 0, 1);
  EXPECT_FLOAT_EQ(DisneyBsdf(p, wo).subsurface_entry().g, 0.5f * 0.75f * 0.75f);
  p.diff_trans_color = {0, 1, 0};
  const Vec3f wi = normalize(Vec3f(1, 0, -0.01f));
  const Rgb beyond = testing::f_of(DisneyTransmissiveBsdf(p, wo, {1.5f, false}).evaluate(wi), wi);
  EXPECT_FLOAT_EQ(beyond.g, 0.5f * 0.75f * 0.25f * kInvPi);
  EXPECT_EQ(beyond.r, 0) << "no facet refracts there";
  p.thin = true;
  EXPECT_TRUE(is_black(DisneyBsdf(p, wo).subsurface_entry())) << "a sheet has no interior";
}

}  // namespace
}  // namespace alabaster
