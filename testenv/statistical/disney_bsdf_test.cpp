// Samplers against pdfs (chi-square), and the energy that lobes reflect (white furnace, albedo by samples against
// quadrature).
#include "core/material/disney_bsdf.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <string>
#include <vector>

#include "core/sampling/warp.h"
#include "testenv/support/chi_square.h"
#include "testenv/support/material_testing.h"
#include "testenv/support/z_test.h"

namespace alabaster {
namespace {

using testing::chi_square_sphere;
using testing::ChiSquareOptions;
using testing::ChiSquareResult;
using testing::integrate_sphere;
using testing::RunningStatistics;
using testing::uniform2;
using testing::z_test;

Vec3f at_angle(double degrees) {
  const double theta = degrees * std::acos(-1.0) / 180;
  // Off the axes, so that swapping x and y has an effect.
  return {static_cast<float>(std::sin(theta) * 0.8), static_cast<float>(std::sin(theta) * 0.6),
          static_cast<float>(std::cos(theta))};
}

const double kAngles[] = {0, 50, 75, 89};

/// Bins around the mirror direction; sharper lobes need a larger exponent.
ChiSquareOptions options_at(const Vec3f& wo, double exponent) {
  ChiSquareOptions options;
  options.bins_x = options.bins_y = 20;
  options.samples = 100000;
  options.frame = frame_from_normal({-wo.x, -wo.y, wo.z});
  options.pole_exponent = exponent;
  return options;
}

template <class L>
ChiSquareResult test_lobe(const L& lobe, const Vec3f& wo, double exponent, float wrong = 1) {
  // `wrong` distorts the pdf but keeps its integral near one, to test the test.
  const auto pdf = [&](const Vec3f& wi) { return lobe.evaluate(wo, wi).pdf * (1 + (wrong - 1) * wi.x); };
  return chi_square_sphere([&](Rng& rng) { return lobe.sample(wo, uniform2(rng)); }, pdf, options_at(wo, exponent));
}

struct SpecularCase {
  float alpha_x, alpha_y;
  double exponent;
};

TEST(ChiSquareLobes, Specular) {
  for (const SpecularCase& c :
       {SpecularCase{1, 1, 1}, {0.25f, 0.25f, 2}, {0.5f, 0.05f, 3}, {kMinAlpha, kMinAlpha, 10}}) {
    for (double angle : kAngles) {
      DisneySpecular lobe;
      lobe.ggx = {c.alpha_x, c.alpha_y};
      const auto result = test_lobe(lobe, at_angle(angle), c.exponent);
      EXPECT_TRUE(plausible(result)) << c.alpha_x << " " << c.alpha_y << " at " << angle;
    }
  }
}

TEST(ChiSquareLobes, Clearcoat) {
  for (float gloss : {0.0f, 1.0f}) {
    for (double angle : kAngles) {
      const auto lobe = DisneyClearcoat::from(1, gloss);
      const auto result = test_lobe(lobe, at_angle(angle), gloss == 1 ? 6 : 3);
      EXPECT_TRUE(plausible(result)) << gloss << " at " << angle;
    }
  }
}

TEST(ChiSquareLobes, DiffuseAndSheen) {
  const DisneyDiffuse diffuse{Rgb(1.0f), Rgb(1.0f), 0.5f};
  const auto a = test_lobe(diffuse, at_angle(60), 1);
  EXPECT_TRUE(plausible(a));
  const DisneySheen sheen{Rgb(1.0f)};
  const auto b = test_lobe(sheen, at_angle(60), 1);
  EXPECT_TRUE(plausible(b));
}

// Deliberately wrong densities: a tilt, the alpha of another roughness, the pdf without masking.
TEST(ChiSquareLobes, WrongPdfsAreRefused) {
  const Vec3f wo = at_angle(50);
  DisneySpecular lobe;
  lobe.ggx = {0.25f, 0.25f};
  EXPECT_TRUE(noticed(test_lobe(lobe, wo, 2, 1.1f)));
  EXPECT_TRUE(noticed(test_lobe(DisneyClearcoat::from(1, 0), wo, 3, 1.1f)));
  EXPECT_TRUE(noticed(test_lobe(DisneyDiffuse{Rgb(1.0f), Rgb(1.0f), 0}, wo, 1, 1.1f)));
  const auto sample = [&](Rng& rng) { return lobe.sample(wo, uniform2(rng)); };
  DisneySpecular other = lobe;
  other.ggx = {0.26f, 0.26f};
  const auto wider = [&](const Vec3f& wi) { return other.evaluate(wo, wi).pdf; };
  EXPECT_TRUE(noticed(chi_square_sphere(sample, wider, options_at(wo, 2))));
  const auto all_normals = [&](const Vec3f& wi) {
    const auto facet = mirror_facet(wo, wi);
    return wi.z > 0 && facet ? lobe.ggx.d(facet->wm) * facet->wm.z / (4 * facet->cos_d) : 0;
  };
  EXPECT_TRUE(noticed(chi_square_sphere(sample, all_normals, options_at(wo, 2))));
}

struct NamedParameters {
  std::string name;
  DisneyParameters p;
  double exponent;
};

std::vector<NamedParameters> materials() {
  std::vector<NamedParameters> list(9);
  list[0] = {"plastic", {}, 2};
  list[1].name = "skin";
  list[1].p.base_color = {0.9f, 0.6f, 0.45f};
  list[1].p.scatter_distance = {1, 0.35f, 0.2f};
  list[1].p.roughness = 0.4f;
  list[1].exponent = 2;
  list[2].name = "brushed metal";
  list[2].p.metallic = 1;
  list[2].p.anisotropic = 0.8f;
  list[2].p.roughness = 0.4f;
  list[2].exponent = 2;
  list[3].name = "lacquered cloth, one channel scattering";
  list[3].p.base_color = {0.1f, 0.2f, 0.8f};
  list[3].p.sheen = list[3].p.clearcoat = list[3].p.roughness = 1;
  list[3].p.scatter_distance = {0, 0, 2};
  list[3].p.metallic = 0.3f;
  list[3].exponent = 6;
  list[4].name = "roughness 0";
  list[4].p.roughness = 0;
  list[4].exponent = 8;
  list[5].name = "tinted, half metal";
  list[5].p.base_color = {0.05f, 0.1f, 0.9f};
  list[5].p.specular_tint = 1;
  list[5].p.metallic = 0.5f;
  list[5].p.roughness = 0.7f;
  list[5].p.specular_color = {1, 0, 1};
  list[5].exponent = 2;
  list[6].name = "coated skin";
  list[6].p = list[1].p;
  list[6].p.coat = 1;
  list[6].p.coat_roughness = 0.3f;
  list[6].p.coat_ior = 1.8f, list[6].p.coat_color = {0.8f, 0.5f, 0.3f}, list[6].p.coat_darkening = 0.5f;
  list[6].p.coat_normal = list[6].p.surface_normal = normalize(Vec3f(0.3f, -0.2f, 1));
  list[6].exponent = 3;
  list[7].name = "velvet";
  list[7].p.sheen = 1;
  list[7].p.sheen_roughness = 0.4f;
  list[7].p.sheen_color = {0.9f, 0.5f, 0.1f};
  list[7].exponent = 1;
  list[8].name = "half skin";
  list[8].p = list[1].p;
  list[8].p.subsurface_weight = 0.4f;
  list[8].p.subsurface_color = {0.3f, 0.9f, 0.2f};
  list[8].exponent = 2;
  return list;
}

// The walk's choice and the samples lost below the horizon make up the bin of missing samples.
TEST(ChiSquareBsdf, WholeBsdf) {
  for (const NamedParameters& m : materials()) {
    for (double angle : {10.0, 80.0}) {
      const Vec3f wo = at_angle(angle);
      const DisneyBsdf bsdf(m.p, wo);
      const auto sample = [&](Rng& rng) -> std::optional<Vec3f> {
        const float u_lobe = rng.uniform();
        const auto s = bsdf.sample(u_lobe, uniform2(rng));
        if (!s || s->lobe == Lobe::subsurface) return std::nullopt;
        return s->wi;
      };
      const auto pdf = [&](const Vec3f& wi) { return bsdf.evaluate(wi).pdf; };
      const auto result = chi_square_sphere(sample, pdf, options_at(wo, m.exponent));
      EXPECT_TRUE(plausible(result)) << m.name << " at " << angle;
    }
  }
  // A pdf without the probability of choosing the walk.
  const NamedParameters skin = materials()[1];
  DisneyParameters local = skin.p;
  local.scatter_distance = Rgb(0.0f);
  const Vec3f wo = at_angle(10);
  const DisneyBsdf bsdf(skin.p, wo), without(local, wo);
  const auto sample = [&](Rng& rng) -> std::optional<Vec3f> {
    const float u_lobe = rng.uniform();
    const auto s = bsdf.sample(u_lobe, uniform2(rng));
    if (!s || s->lobe == Lobe::subsurface) return std::nullopt;
    return s->wi;
  };
  EXPECT_TRUE(noticed(chi_square_sphere(
      sample, [&](const Vec3f& wi) { return without.evaluate(wi).pdf; }, options_at(wo, 2))));
}

template <class F>
double albedo_by_quadrature(const Vec3f& wo, const F& f, double exponent) {
  const Frame mirror = frame_from_normal({-wo.x, -wo.y, wo.z});
  return integrate_sphere([&](const Vec3f& wi) { return wi.z > 0 ? double(f(wi)) * double(wi.z) : 0; }, mirror,
                          exponent);
}

// Compares the closed form A (1-.5F_V)(1-1/42) + E_retro with quadrature, at any roughness.
TEST(Furnace, DiffuseAlbedoIsAnalytic) {
  double highest = 0;
  for (float roughness : {0.0f, 0.5f, 1.0f}) {
    for (double angle : {0.0, 30.0, 60.0, 80.0, 85.0, 89.0, 89.9}) {
      const Vec3f wo = at_angle(angle);
      const DisneyDiffuse lobe{Rgb(1.0f), Rgb(1.0f), roughness};
      const double measured = albedo_by_quadrature(
          wo, [&](const Vec3f& wi) { return lobe.evaluate(wo, wi).f.g; }, 1);
      EXPECT_NEAR(measured, double(lobe.albedo(wo).g), 5e-5) << roughness << " at " << angle;
      if (roughness == 0) {
        const double fv = std::pow(1 - double(wo.z), 5);
        EXPECT_NEAR(measured, (1 - 0.5 * fv) * (1 - 1.0 / 42), 5e-5);
      }
      highest = std::max(highest, measured);
    }
  }
  std::printf("diffuse: highest albedo of white at roughness 1, grazing: %.4f\n", highest);
  // Grazing limit of the closed form at roughness 1: 41/84 + 1 + (1/21 + (1/21 - 1/252)/2) = 1.5575.
  EXPECT_NEAR(highest, 41.0 / 84 + 1 + 1.0 / 21 + 0.5 * (1.0 / 21 - 1.0 / 252), 2e-2);
}

// The share of a white furnace that each lobe of a white, fully reflecting material returns. The model guarantees at
// most one for specular, clearcoat and sheen by themselves and for the Lambert part. The retro-reflective part makes
// white diffuse exceed one: 1.006 at roughness 0.5 and 1.036 at roughness 1, seen head on, and 1.5575 in the grazing
// limit.
TEST(Furnace, WhiteFurnacePerLobe) {
  std::printf("%-28s", "white furnace at degrees");
  for (double angle : kAngles) std::printf("%9.0f", angle);
  std::printf("\n");
  const auto row = [&](const std::string& name, const auto& lobe, double exponent, double bound) {
    std::printf("%-28s", name.c_str());
    for (double angle : kAngles) {
      const Vec3f wo = at_angle(angle);
      const double e = albedo_by_quadrature(
          wo, [&](const Vec3f& wi) { return lobe.evaluate(wo, wi).f.g; }, exponent);
      std::printf("%9.4f", e);
      EXPECT_LE(e, bound + 1e-4) << name << " at " << angle;
      EXPECT_GT(e, 0);
      if (std::string(name).starts_with("sheen")) {
        EXPECT_GT(double(lobe.albedo(wo).g), 0.4 * e);
        EXPECT_LT(double(lobe.albedo(wo).g), 2.2 * e);
      }
    }
    std::printf("\n");
  };
  for (const auto& [r, exponent] : {std::pair{0.1f, 5.0}, {0.5f, 2.0}, {1.0f, 1.0}}) {
    DisneySpecular specular;
    specular.f0 = specular.f90 = Rgb(1.0f);
    specular.ggx = {r * r, r * r};
    row("specular, roughness " + std::to_string(r), specular, exponent, 1);
  }
  row("clearcoat 1, gloss 0", DisneyClearcoat::from(1, 0), 3, 0.25);
  row("clearcoat 1, gloss 1", DisneyClearcoat::from(1, 1), 6, 0.25);
  row("sheen 1, white", DisneySheen{Rgb(1.0f)}, 1, 0.0885);
  row("diffuse, roughness 0", DisneyDiffuse{Rgb(1.0f), Rgb(1.0f), 0}, 1, 1 - 1.0 / 42);
  row("diffuse, roughness 0.5", DisneyDiffuse{Rgb(1.0f), Rgb(1.0f), 0.5f}, 1, 1.1);
  row("diffuse, roughness 1", DisneyDiffuse{Rgb(1.0f), Rgb(1.0f), 1}, 1, 1.5576);
}

TEST(Furnace, FibresReduceTheBaseByWhatTheyReflect) {
  for (float roughness : {0.0f, 0.1f, 0.2f, 0.5f, 1.0f}) {
    const CharlieSheen fibres = CharlieSheen::from(Rgb(1.0f), roughness);
    for (double angle : kAngles) {
      const Vec3f wo = at_angle(angle);
      const double reflected = albedo_by_quadrature(
          wo, [&](const Vec3f& wi) { return fibres.evaluate(wo, wi).f.g; }, 1);
      const double below = albedo_by_quadrature(
          wo, [&](const Vec3f& wi) { return kInvPi * fibres.over(wo.z, wi.z); }, 1);
      std::printf("fibres of roughness %.1f at %2.0f degrees: reflect %.4f, with white below %.4f\n", double(roughness),
                  angle, reflected, reflected + below);
      const double albedo = double(fibres.albedo(wo).g);
      EXPECT_LE(reflected, albedo + 0.001) << roughness << " at " << angle;
      EXPECT_GE(reflected, albedo - 0.02) << "limited for grazing partners: " << roughness << " at " << angle;
      EXPECT_LE(reflected + below, 1.001) << roughness << " at " << angle;
    }
  }
}

// A coat takes its reflection from the base: a Lambertian one keeps exactly passed(wo), a rough mirror as much as its
// albedo allows.
TEST(Furnace, CoatReducesTheBaseByWhatItReflects) {
  DisneyParameters p;
  p.coat = 1, p.coat_roughness = 0.3f;
  const DisneyCoat coat = DisneyCoat::from(p);
  DisneySpecular metal;
  metal.f0 = metal.f90 = Rgb(1.0f);
  metal.ggx = {0.09f, 0.09f};
  for (double angle : kAngles) {
    const Vec3f wo = at_angle(angle);
    const double base = albedo_by_quadrature(
        wo, [&](const Vec3f& wi) { return kInvPi * coat.over_diffuse(wo, wi); }, 1);
    EXPECT_NEAR(base, double(coat.passed(wo)), 1e-4) << angle;
    const double layer = albedo_by_quadrature(
        wo, [&](const Vec3f& wi) { return testing::f_of(coat.evaluate(wo, wi), wi).g; }, 3);
    const double mirror = albedo_by_quadrature(
        wo, [&](const Vec3f& wi) { return metal.evaluate(wo, wi).f.g * coat.over_specular(wo, wi); }, 3);
    std::printf("coat at %2.0f degrees: reflects %.4f, white %.4f, mirror %.4f\n", angle, layer, base + layer,
                mirror + layer);
    EXPECT_LE(base + layer, 1.01) << angle;
    EXPECT_LE(mirror + layer, 1.01) << angle;
    // Facets that mask each other lose more at grazing view.
    if (angle < 80) {
      EXPECT_GE(base + layer, 0.9) << angle;
    }
  }
}

template <class L>
void expect_sampled_albedo(const L& lobe, const Vec3f& wo, double exponent, double bound, const std::string& name) {
  const double expected = albedo_by_quadrature(
      wo, [&](const Vec3f& wi) { return lobe.evaluate(wo, wi).f.g; }, exponent);
  Rng rng(testing::run_seed(42), 7);
  RunningStatistics weights;
  for (int i = 0; i < testing::run_samples(50000); ++i) {
    const auto wi = lobe.sample(wo, uniform2(rng));
    const LobeValue value = wi ? lobe.evaluate(wo, *wi) : LobeValue();
    weights.add(value.pdf > 0 ? double(value.f.g) * double(wi->z) / double(value.pdf) : 0);
  }
  const auto result = z_test(weights, expected, {.slack = 2e-5});
  EXPECT_TRUE(plausible(result)) << name;
  EXPECT_LE(weights.max(), bound) << name;
}

TEST(Furnace, LobeAlbedoBySamplesEqualsQuadrature) {
  for (double angle : kAngles) {
    const Vec3f wo = at_angle(angle);
    for (const SpecularCase& c : {SpecularCase{1, 1, 1}, {0.25f, 0.25f, 2}, {0.5f, 0.05f, 3}}) {
      DisneySpecular specular;
      specular.f0 = Rgb(0.04f);
      specular.f90 = Rgb(1.0f);
      specular.ggx = {c.alpha_x, c.alpha_y};
      // f cos / pdf = F G1(wi).
      expect_sampled_albedo(specular, wo, c.exponent, 1 + 1e-5, "specular");
    }
    // pi f is at most (1 + (F_D90-1))^2 = 2.5^2.
    expect_sampled_albedo(DisneyDiffuse{Rgb(1.0f), Rgb(1.0f), 1}, wo, 1, 6.25 + 1e-4, "diffuse");
    expect_sampled_albedo(DisneySheen{Rgb(1.0f)}, wo, 1, 3.15, "sheen");
    // F (wo.wm) G1 G1 / (wo.z wm.z) / 4, where each masking term is at most 8 times its cosine.
    expect_sampled_albedo(DisneyClearcoat::from(1, 0), wo, 3, 4, "clearcoat");
  }
}

TEST(Furnace, WholeBsdfBySamplesEqualsQuadrature) {
  for (const NamedParameters& m : materials()) {
    if (m.p.roughness == 0) continue;  // its quadrature is less exact than its samples
    for (double angle : {20.0, 80.0}) {
      const Vec3f wo = at_angle(angle);
      const DisneyBsdf bsdf(m.p, wo);
      Rng rng(testing::run_seed(9), 1);
      RunningStatistics local[3], entry[3];
      for (int i = 0; i < testing::run_samples(50000); ++i) {
        const float u_lobe = rng.uniform();
        const auto s = bsdf.sample(u_lobe, uniform2(rng));
        const bool walk = s && s->lobe == Lobe::subsurface;
        for (int c = 0; c < 3; ++c) {
          local[c].add(s && !walk ? double(s->weight()[c]) : 0);
          entry[c].add(walk ? double(s->weight()[c]) : 0);
        }
      }
      for (int c = 0; c < 3; ++c) {
        const double e = albedo_by_quadrature(
            wo, [&](const Vec3f& wi) { return testing::f_of(bsdf.evaluate(wi), wi)[c]; }, m.exponent);
        const auto r = z_test(local[c], e, {.slack = 2e-5});
        EXPECT_TRUE(plausible(r)) << m.name << " at " << angle << " channel " << c;
        const auto q = z_test(entry[c], double(bsdf.subsurface_entry()[c]));
        EXPECT_TRUE(plausible(q)) << m.name << " entry, channel " << c;
      }
    }
  }
}

// Without retro-reflection, the light that enters and leaves through the medium's lobes equals that of the Lambert
// part: (1-.5F_V) Int (1/pi)(1-.5F_L) cos = (1-.5F_V)(1-1/42).
TEST(Furnace, EntryTimesExitIsTheLambertPart) {
  DisneyParameters p;
  p.scatter_distance = Rgb(1.0f);
  for (double angle : kAngles) {
    const Vec3f wo = at_angle(angle);
    const double exit = albedo_by_quadrature(
        {0, 0, 1}, [](const Vec3f& wi) { return subsurface_exit_f_cos(wi.z) / wi.z; }, 1);
    const double both = double(DisneyBsdf(p, wo).subsurface_entry().g) * exit;
    EXPECT_NEAR(both, double(DisneyDiffuse::lambert_albedo(wo.z)), 2e-5);
  }
}

}  // namespace
}  // namespace alabaster
