// The energy that the Disney BSDF reflects of a furnace, and the tables that bound it.
#include <gtest/gtest.h>

#include "core/material/directional_albedo.h"
#include "core/material/disney_clearcoat.h"
#include "core/material/disney_sheen.h"
#include "core/material/disney_transmissive_bsdf.h"
#include "core/sampling/warp.h"
#include "testenv/support/chi_square.h"
#include "testenv/support/material_testing.h"
#include "testenv/support/z_test.h"

namespace alabaster {
namespace {

using testing::RunningStatistics;
using testing::uniform2;

Vec3f along(float cosine, float phi = 0) {
  const float sine = safe_sqrt(1 - sqr(cosine));
  return {sine * std::cos(phi), sine * std::sin(phi), cosine};
}

/// The brightest channel of what is reflected, by samples.
template <class Bsdf>
RunningStatistics reflected(const Bsdf& bsdf, int samples, Rng& rng) {
  RunningStatistics channels[3];
  for (int i = 0; i < testing::run_samples(samples); ++i) {
    const auto sample = bsdf.sample(rng.uniform(), uniform2(rng));
    const Rgb share = sample ? sample->weight() : Rgb(0.0f);
    for (int c = 0; c < 3; ++c) channels[c].add(static_cast<double>(share[c]));
  }
  return *std::max_element(std::begin(channels), std::end(channels),
                           [](const auto& a, const auto& b) { return a.mean() < b.mean(); });
}

/// As reflected(), of green, by stratified samples: far less noise. Each of its values is a mean over 4096.
RunningStatistics reflected_evenly(const DisneyBsdf& bsdf, Rng& rng) {
  RunningStatistics shares;
  constexpr int kRuns = 12, kSide = 64;
  for (int run = 0; run < kRuns; ++run) {
    double sum = 0;
    float u_lobe = rng.uniform();
    for (int i = 0; i < kSide * kSide; ++i) {
      u_lobe += 0.618034f;
      u_lobe -= std::floor(u_lobe);
      const Vec2f jitter = uniform2(rng);
      const auto s = bsdf.sample(std::min(u_lobe, kOneMinusEpsilon),
                                 {(float(i % kSide) + jitter.x) / kSide, (float(i / kSide) + jitter.y) / kSide});
      if (s) sum += double(s->weight().g);
    }
    shares.add(sum / (kSide * kSide));
  }
  return shares;
}

float either(Rng& rng, float low, float high) {
  const uint32_t pick = rng.next() % 3;
  return pick == 0 ? low : pick == 1 ? high : lerp(low, high, rng.uniform());
}

/// Published lobes alone: those of glTF have tables of their own.
DisneyParameters published(Rng& rng) {
  DisneyParameters p;
  p.base_color = {either(rng, 0.3f, 1), either(rng, 0, 1), 0.8f};
  p.metallic = rng.next() % 2 ? either(rng, 0, 1) : 0;
  p.roughness = either(rng, 0, 1);
  p.specular_tint = either(rng, 0, 1);
  p.ior = either(rng, 1, 4);
  p.sheen = either(rng, 0, 1);
  p.clearcoat = either(rng, 0, 1);
  p.clearcoat_gloss = either(rng, 0, 1);
  return p;
}

constexpr int kSamples = 20000, kCases = 300;
// Means of many cases at five standard errors: one false alarm in 6000 runs.
double surely_above(const RunningStatistics& share) {
  return share.mean() - 5 * share.standard_error();
}

TEST(DisneyEnergy, BoundedReflectsNoMoreThanItReceives) {
  Rng rng(testing::run_seed(61), 1);
  double published_most = 0;
  for (int i = 0; i < kCases; ++i) {
    const DisneyParameters p = published(rng);
    const Vec3f wo = along(std::max(0.003f, rng.next() % 2 ? rng.uniform() : sqr(sqr(rng.uniform()))));
    published_most = std::max(published_most, surely_above(reflected(DisneyBsdf(p, wo), kSamples / 10, rng)));
    for (const EnergyModel energy : {EnergyModel::bounded, EnergyModel::conserving})
      EXPECT_LE(surely_above(reflected(DisneyBsdf(p, wo, energy), kSamples, rng)), 1 + 1e-3)
          << i << " at " << wo.z << " roughness " << p.roughness << " ior " << p.ior << " metallic " << p.metallic;
  }
  EXPECT_GT(published_most, 1.3);  // otherwise nothing was bounded
}

TEST(DisneyEnergy, LayersAndFilmsAreBoundedToTwoPercent) {
  Rng rng(testing::run_seed(61), 2);
  for (int i = 0; i < kCases; ++i) {
    DisneyParameters p = published(rng);
    const uint32_t kind = rng.next() % 3;
    if (kind == 0) p.coat = either(rng, 0, 1), p.coat_roughness = either(rng, 0, 1), p.coat_ior = either(rng, 1, 4);
    if (kind == 1) p.sheen_roughness = either(rng, 0, 1);
    if (kind == 2) p.iridescence = either(rng, 0, 1), p.iridescence_thickness = either(rng, 100, 1000);
    const Vec3f wo = along(std::max(0.003f, rng.uniform()), 1.5f * rng.uniform());
    EXPECT_LE(surely_above(reflected(DisneyBsdf(p, wo, EnergyModel::bounded), kSamples, rng)), 1.02)
        << kind << " at " << wo.z << " roughness " << p.roughness << " ior " << p.ior;
  }
}

TEST(DisneyEnergy, SurfacesThatLightPassesAreBounded) {
  Rng rng(testing::run_seed(61), 3);
  for (int i = 0; i < kCases; ++i) {
    DisneyParameters p = published(rng);
    p.base_color = p.diff_trans_color = Rgb(1.0f);
    p.spec_trans = either(rng, 0, 1);
    p.diff_trans = either(rng, 0, 2);
    p.thin = rng.next() % 2;
    if (p.thin) p.flatness = either(rng, 0, 1);
    if (p.thin && i % 2) p.opacity_mode = OpacityMode::transparent;
    const Vec3f wo = along(std::max(0.003f, rng.uniform()));
    // The index is equal on both sides: light that crosses into another medium has its radiance scaled.
    const DisneyTransmissiveBsdf bsdf(p, wo, {1, false}, EnergyModel::bounded);
    EXPECT_LE(surely_above(reflected(bsdf, kSamples, rng)), 1 + 2e-3)
        << i << " at " << wo.z << " thin " << p.thin << " specTrans " << p.spec_trans << " diffTrans " << p.diff_trans
        << " flatness " << p.flatness;
  }
}

TEST(DisneyEnergy, TheWalksShareIsExactAndTheOthersYieldToIt) {
  DisneyParameters p;
  p.base_color = {1, 0.5f, 0};
  p.scatter_distance = {1, 1, 0};
  const Vec3f wo = along(0.7f);
  const DisneyBsdf plain(p, wo), bounded(p, wo, EnergyModel::bounded);
  EXPECT_EQ(plain.subsurface_entry(), bounded.subsurface_entry());
  Rng rng(testing::run_seed(61), 4);
  double red = 0, samples = 100000;
  for (int i = 0; i < int(samples); ++i)
    if (const auto s = bounded.sample(rng.uniform(), uniform2(rng)); s && s->lobe != Lobe::subsurface)
      red += double(s->weight().r) / samples;
  // An albedo of 1 leaves 1 - (1-.5F)(1-1/42) to all other lobes.
  EXPECT_LE(red + double(DisneyDiffuse::lambert_albedo(wo.z)), 1.001);
  EXPECT_GT(red + double(DisneyDiffuse::lambert_albedo(wo.z)), 0.99);
}

TEST(DisneyEnergy, EnergyConservingSurfacesAreThePublishedModel) {
  DisneyParameters p;
  p.base_color = Rgb(0.5f);
  p.clearcoat = p.sheen = 0.5f;
  for (const float o : {0.5f, 0.8f, 1.0f})
    for (const float i : {0.5f, 0.7f, 1.0f})
      for (const float phi : {0.0f, 2.0f, 3.1f}) {
        const BsdfValue a = DisneyBsdf(p, along(o)).evaluate(along(i, phi));
        const BsdfValue b = DisneyBsdf(p, along(o), EnergyModel::bounded).evaluate(along(i, phi));
        EXPECT_EQ(a.f_cos, b.f_cos);
        EXPECT_EQ(a.pdf, b.pdf);
      }
  p.base_color = Rgb(1.0f);
  EXPECT_LT(DisneyBsdf(p, along(0.8f), EnergyModel::bounded).evaluate(along(0.7f)).f_cos.g,
            DisneyBsdf(p, along(0.8f)).evaluate(along(0.7f)).f_cos.g);
}

TEST(DisneyEnergy, RoughWhiteMetalReflectsAllWhereEnergyIsConserved) {
  Rng rng(testing::run_seed(61), 5);
  DisneyParameters p;
  p.base_color = Rgb(1.0f);
  p.metallic = 1;
  for (const float roughness : {0.2f, 0.5f, 0.8f, 1.0f})
    for (const float cosine : {0.05f, 0.3f, 0.7f, 1.0f}) {
      p.roughness = roughness;
      const auto share = reflected(DisneyBsdf(p, along(cosine), EnergyModel::conserving), 200000, rng);
      EXPECT_TRUE(plausible(z_test(share, 1, {.slack = 5e-3}))) << roughness << " at " << cosine;
    }
  EXPECT_LT(reflected(DisneyBsdf(p, along(1), EnergyModel::bounded), kSamples, rng).mean(), 0.5);
}

// As published the loss of anisotropic facets is not that of isotropic ones: at 1.11 up to .88 of the light was gone.
TEST(DisneyEnergy, AnisotropicWhiteMetalReflectsAllWhereEnergyIsConserved) {
  Rng rng(testing::run_seed(61), 9);
  DisneyParameters p;
  p.base_color = Rgb(1.0f);
  p.metallic = 1;
  for (const float anisotropic : {0.3f, 0.9f, 1.0f, 1.11f})
    for (const float roughness : {0.2f, 0.5f, 1.0f})
      for (const float cosine : {0.09f, 0.5f, 1.0f})
        for (const float phi : {0.0f, 0.7f, 1.5f, 1.5708f}) {
          if (cosine == 1 && phi > 0) continue;
          p.anisotropic = anisotropic, p.roughness = roughness;
          const auto share = reflected_evenly({p, along(cosine, phi), EnergyModel::conserving}, rng);
          EXPECT_TRUE(plausible(z_test(share, 1, {.slack = 3e-3})))
              << anisotropic << " roughness " << roughness << " at " << cosine << " " << phi;
        }
}

// Towards y, few directions see facets that are stretched along x.
TEST(DisneyEnergy, AlbedosOfFacetsThatAreStretchedFar) {
  constexpr int kPoints = 400;
  for (const auto& [anisotropic, roughness] : {std::pair(1.11f, 0.5f), {1.11f, 1.0f}, {1.0f, 0.7f}})
    for (const float cosine : {0.09f, 0.5f, 0.985f})
      for (const float phi : {0.0f, 0.7f, 1.55f, 1.5708f}) {
        const Ggx ggx = disney_ggx(roughness, anisotropic);
        const Vec3f wo = along(cosine, phi);
        double sum = 0;
        for (int i = 0; i < kPoints * kPoints; ++i) {
          const float rest = 1 - (static_cast<float>(i % kPoints) + 0.5f) / kPoints;
          const float turn = (static_cast<float>(i / kPoints) + 0.3f) / kPoints;
          const Vec3f wi = reflect_about(wo, ggx.sample(wo, {1 - rest * rest * rest, turn}));
          if (wi.z > 0) sum += double(3 * rest * rest * wi.z * ggx.g1_over_cos(wi));
        }
        EXPECT_NEAR(double(ggx_albedo(wo, ggx).white), sum / (kPoints * kPoints), 3e-3)
            << anisotropic << " roughness " << roughness << " at " << cosine << " " << phi;
      }
}

TEST(DisneyEnergy, AnisotropicSurfacesAreBounded) {
  Rng rng(testing::run_seed(61), 10);
  for (const float ior : {1.5f, 4.0f})
    for (const float anisotropic : {0.9f, 1.0f, 1.11f})
      for (const float roughness : {0.1f, 0.2f})
        for (const float cosine : {0.087f, 0.3f})
          for (const float phi : {0.0f, 0.7f, 1.5708f})
            for (const EnergyModel energy : {EnergyModel::bounded, EnergyModel::conserving}) {
              DisneyParameters p;
              p.base_color = Rgb(1.0f);
              p.ior = ior, p.anisotropic = anisotropic, p.roughness = roughness;
              const auto share = reflected_evenly({p, along(cosine, phi), energy}, rng);
              EXPECT_TRUE(plausible(testing::at_most_test(share, 1 + 1e-3)))
                  << ior << " " << anisotropic << " roughness " << roughness << " at " << cosine << " " << phi;
            }
}

// Little light meets several facets of a fairly smooth metal, so few samples go to that lobe.
TEST(DisneyEnergy, TheLobeOfSeveralFacetsIsChosenByItsAlbedo) {
  DisneyParameters p;
  p.base_color = Rgb(1.0f);
  p.metallic = 1;
  p.roughness = 0.3f;
  Rng rng(testing::run_seed(61), 8);
  int spread = 0;
  constexpr int kTries = 20000;
  const DisneyBsdf bsdf(p, along(0.7f), EnergyModel::conserving);
  for (int i = 0; i < kTries; ++i)
    if (const auto sample = bsdf.sample(rng.uniform(), uniform2(rng)); sample && sample->lobe == Lobe::diffuse)
      ++spread;
  const double lost = 1 - double(ggx_albedo(along(0.7f), disney_ggx(p.roughness, 0)).white);
  EXPECT_NEAR(double(spread) / kTries, lost, 0.5 * lost + 3e-3);
}

// Sampling has the pdf that evaluate() says, with the lobe of several facets too: Int f cos by samples of the BSDF and
// by samples of the hemisphere.
TEST(DisneyEnergy, SamplesAgreeWithQuadrature) {
  Rng rng(testing::run_seed(61), 6);
  for (int i = 0; i < 20; ++i) {
    DisneyParameters p = published(rng);
    p.roughness = lerp(0.4f, 1.0f, rng.uniform());
    p.clearcoat = 0;
    const DisneyBsdf bsdf(p, along(lerp(0.1f, 1.0f, rng.uniform())), EnergyModel::conserving);
    RunningStatistics by_samples, by_hemisphere;
    for (int s = 0; s < testing::run_samples(100000); ++s) {
      const auto sample = bsdf.sample(rng.uniform(), uniform2(rng));
      by_samples.add(sample ? double(sample->weight().g) : 0);
      const Vec3f wi = sample_cosine_hemisphere(uniform2(rng));
      by_hemisphere.add(double(testing::f_of(bsdf.evaluate(wi), wi).g * kPi));
    }
    EXPECT_TRUE(plausible(z_test(by_samples, by_hemisphere))) << i;
  }
}

/// Int f wi.z dwi of a lobe by its own samples.
template <class L>
RunningStatistics albedo_of(const L& lobe, const Vec3f& wo, Rng& rng) {
  RunningStatistics statistics;
  for (int i = 0; i < testing::run_samples(200000); ++i) {
    const auto wi = lobe.sample(wo, uniform2(rng));
    const LobeValue value = wi ? lobe.evaluate(wo, *wi) : LobeValue();
    statistics.add(value.pdf > 0 ? double(value.f.r * wi->z / value.pdf) : 0);
  }
  return statistics;
}

struct FlatLobe {
  float roughness;
  LobeValue evaluate(const Vec3f& wo, const Vec3f& wi) const {
    return {Rgb(DisneyDiffuse::flat(wo, wi, roughness)), pdf_cosine_hemisphere(wi)};
  }
  std::optional<Vec3f> sample(const Vec3f&, const Vec2f& u) const { return sample_cosine_hemisphere(u); }
};

TEST(DirectionalAlbedo, BoundsForSteepDirectionsHold) {
  for (const SteepAlbedos& steep : kSteepAlbedos)
    for (float cosine = steep.cosine; cosine < 1.005f; cosine += 0.01f) {
      const float c = std::min(1.0f, cosine);
      EXPECT_LE(sheen_albedo(c), steep.sheen);
      for (float roughness = 0.01f; roughness <= 1; roughness += 0.03f) {
        EXPECT_LE(clearcoat_albedo(c, DisneyClearcoat::from(1, roughness).gtr1.alpha), steep.clearcoat);
        EXPECT_LE(DisneyDiffuse::retro_albedo(c, roughness), DisneyDiffuse::retro_albedo(steep.cosine, roughness));
        for (const float anisotropic : {0.0f, 0.6f, 1.0f}) {
          // Each shape of anisotropic facets has a table of its own.
          if (anisotropic > 0 && std::fmod(roughness, 0.24f) > 0.03f) continue;
          for (const float phi : {0.0f, 0.7f, 1.57f}) {
            const GgxAlbedo facets = ggx_albedo(along(c, phi), disney_ggx(roughness, anisotropic));
            EXPECT_LE(facets.schlick, steep.schlick) << c << " " << roughness << " " << anisotropic << " " << phi;
            EXPECT_LE(facets.white, 1.0f) << c << " " << roughness << " " << anisotropic << " " << phi;
          }
        }
      }
    }
}

TEST(DirectionalAlbedo, TablesAgreeWithSamples) {
  Rng rng(testing::run_seed(61), 7);
  const auto expect = [](double table, const RunningStatistics& exact, double tolerance, const char* lobe, float c) {
    EXPECT_TRUE(plausible(z_test(exact, table, {.slack = tolerance}))) << lobe << " at " << c;
  };
  for (const float cosine : {0.053f, 0.11f, 0.37f, 0.71f, 0.97f})
    for (const float roughness : {0.13f, 0.33f, 0.77f, 0.98f}) {
      const Vec3f wo = along(cosine);
      const float alpha = sqr(roughness);
      const GgxAlbedo facets = ggx_albedo(wo, {alpha, alpha});
      const auto ggx = [&](float f0, const Ggx& shape) { return DisneySpecular{Rgb(f0), Rgb(1.0f), shape}; };
      expect(double(facets.white), albedo_of(ggx(1, {alpha, alpha}), wo, rng), 1e-3, "white", cosine);
      expect(double(facets.schlick), albedo_of(ggx(0, {alpha, alpha}), wo, rng), 1e-3, "schlick", cosine);
      const Ggx stretched{alpha * 2, alpha * 0.5f};
      const Vec3f aside = along(cosine, 0.6f);
      expect(double(ggx_albedo(aside, stretched).white), albedo_of(ggx(1, stretched), aside, rng), 3e-3, "stretched",
             cosine);
      const DisneyClearcoat coat = DisneyClearcoat::from(1, roughness);
      expect(double(clearcoat_albedo(cosine, coat.gtr1.alpha)), albedo_of(coat, wo, rng), 1e-3, "clearcoat", cosine);
      expect(double(sheen_albedo(cosine)), albedo_of(DisneySheen{Rgb(1.0f)}, wo, rng), 1e-4, "sheen", cosine);
      expect(double(flat_albedo(cosine, roughness)), albedo_of(FlatLobe{roughness}, wo, rng), 5e-3, "flat", cosine);
    }
}

}  // namespace
}  // namespace alabaster
