// The lobes that let light through: samplers against pdfs on both sides (chi-square), and energy in a white furnace.
#include <gtest/gtest.h>

#include <cstdio>

#include "core/material/disney_transmissive_bsdf.h"
#include "testenv/support/chi_square.h"
#include "testenv/support/z_test.h"

namespace alabaster {
namespace {

using testing::chi_square_sphere;
using testing::ChiSquareOptions;
using testing::ChiSquareResult;
using testing::RunningStatistics;
using testing::uniform2;

Vec3f at_angle(double degrees) {
  const double theta = degrees * std::acos(-1.0) / 180;
  // Off the axes, so that swapping x and y has an effect.
  return {static_cast<float>(std::sin(theta) * 0.8), static_cast<float>(std::sin(theta) * 0.6),
          static_cast<float>(std::cos(theta))};
}

enum class Half { reflected, passed };

bool lies_in(const Vec3f& wi, Half half) {
  return half == Half::reflected ? wi.z > 0 : wi.z < 0;
}

/// The direction about which the light of a smooth surface leaves: bins are fine there. Straight on under total
/// reflection.
Vec3f peak_of(const Vec3f& wo, Half half, float eta) {
  if (half == Half::reflected) return {-wo.x, -wo.y, wo.z};
  const float sin2 = (1 - wo.z * wo.z) / (eta * eta);
  return sin2 < 1 ? Vec3f(-wo.x / eta, -wo.y / eta, -std::sqrt(1 - sin2)) : -wo;
}

struct Peak {
  Half half;
  float eta;
  double exponent;
};

/// Samples and pdf of one side of the surface; those of the other count as missing. `sample(rng)` may be empty.
template <class Sample, class Pdf>
ChiSquareResult test_half(const Sample& sample, const Pdf& pdf, const Vec3f& wo, const Peak& peak) {
  ChiSquareOptions options;
  options.bins_x = options.bins_y = 20;
  options.samples = 100000;
  options.frame = frame_from_normal(peak_of(wo, peak.half, peak.eta));
  options.pole_exponent = peak.exponent;
  const auto half_sample = [&](Rng& rng) -> std::optional<Vec3f> {
    const auto wi = sample(rng);
    return wi && lies_in(*wi, peak.half) ? wi : std::nullopt;
  };
  return chi_square_sphere(
      half_sample, [&](const Vec3f& wi) { return lies_in(wi, peak.half) ? pdf(wi) : 0; }, options);
}

template <class Lobe>
ChiSquareResult test_lobe(const Lobe& lobe, const Vec3f& wo, const Peak& peak) {
  const auto sample = [&](Rng& rng) {
    const float u = rng.uniform();
    return lobe.sample(wo, u, uniform2(rng));
  };
  return test_half(
      sample, [&](const Vec3f& wi) { return lobe.evaluate(wo, wi).pdf; }, wo, peak);
}

struct Shape {
  Ggx ggx;
  double exponent;
};
const Shape kShapes[] = {{{1, 1}, 1}, {{0.25f, 0.25f}, 2}, {{0.5f, 0.05f}, 3}, {{kMinAlpha, kMinAlpha}, 10}};

TEST(ChiSquareTransmission, SolidFromBothSides) {
  for (const Shape& shape : kShapes)
    for (const float eta : {1.5f, 1 / 1.5f, 1.1f})
      for (const double angle : {0.0, 38.0, 80.0})
        for (const Half half : {Half::reflected, Half::passed}) {
          const bool total = fresnel_dielectric(at_angle(angle).z, eta) == 1;
          if (total && half == Half::passed && shape.ggx.alpha_x == kMinAlpha) continue;  // no facet lets light through
          const DisneyDielectric lobe{{eta, Rgb(1.0f), Rgb(0.8f, 0.5f, 0.2f)}, shape.ggx};
          const auto result = test_lobe(lobe, at_angle(angle), {half, eta, shape.exponent});
          EXPECT_TRUE(plausible(result)) << "alpha " << shape.ggx.alpha_x << " eta " << eta << " at " << angle << " "
                                         << (half == Half::passed);
        }
}

TEST(ChiSquareTransmission, Sheet) {
  for (const Shape& shape : {kShapes[1], kShapes[2]})
    for (const double angle : {0.0, 50.0, 80.0})
      for (const Half half : {Half::reflected, Half::passed}) {
        const Ggx through{shape.ggx.alpha_x * 0.5f, shape.ggx.alpha_y * 0.5f};
        const DisneyThinDielectric lobe{{1.5f, Rgb(1.0f), Rgb(0.8f)}, shape.ggx, through};
        const auto result = test_lobe(lobe, at_angle(angle), {half, 1, shape.exponent});
        EXPECT_TRUE(plausible(result)) << shape.ggx.alpha_x << " at " << angle;
      }
}

DisneyParameters half_clear() {
  DisneyParameters p;
  p.base_color = {0.9f, 0.6f, 0.3f};
  p.roughness = 0.5f;
  p.spec_trans = 0.6f;
  p.metallic = 0.2f;
  p.diff_trans = 0.7f;
  p.clearcoat = 0.5f;
  p.clearcoat_gloss = 0;
  p.scatter_distance = {1, 0.5f, 0};
  return p;
}

std::optional<Vec3f> direction(const DisneyTransmissiveBsdf& bsdf, Rng& rng) {
  const float u_lobe = rng.uniform();
  const auto s = bsdf.sample(u_lobe, uniform2(rng));
  if (!s || s->lobe == Lobe::subsurface || s->lobe == Lobe::straight) return std::nullopt;
  return s->wi;
}

TEST(ChiSquareTransmission, WholeBsdf) {
  for (const bool layered : {false, true})
    for (const bool thin : {false, true})
      for (const bool inside : {false, true})
        for (const double angle : {10.0, 75.0})
          for (const Half half : {Half::reflected, Half::passed}) {
            DisneyParameters p = half_clear();
            p.thin = thin;
            if (layered)
              p.coat = 0.8f, p.coat_roughness = 0.5f, p.sheen = 1, p.sheen_roughness = 0.4f, p.iridescence = 1;
            const Vec3f wo = at_angle(angle);
            const InterfaceSide side{inside ? 1 / 1.5f : 1.5f, inside};
            const DisneyTransmissiveBsdf bsdf(p, wo, side);
            const auto result =
                test_half([&](Rng& rng) { return direction(bsdf, rng); },
                          [&](const Vec3f& wi) { return bsdf.evaluate(wi).pdf; }, wo, {half, thin ? 1 : side.eta, 2});
            EXPECT_TRUE(plausible(result)) << layered << thin << inside << " at " << angle;
          }
}

TEST(ChiSquareTransmission, WrongPdfsAreRefused) {
  const Vec3f wo = at_angle(38);
  const DisneyDielectric lobe{{1.5f, Rgb(1.0f), Rgb(1.0f)}, {0.25f, 0.25f}};
  const auto sample = [&](Rng& rng) {
    const float u = rng.uniform();
    return lobe.sample(wo, u, uniform2(rng));
  };
  const Peak peak{Half::passed, 1.5f, 2};
  DisneyDielectric wider = lobe, denser = lobe;
  wider.ggx = {0.26f, 0.26f};
  denser.boundary.eta = 1.52f;
  EXPECT_TRUE(noticed(test_half(
      sample, [&](const Vec3f& wi) { return wider.evaluate(wo, wi).pdf; }, wo, peak)));
  EXPECT_TRUE(noticed(test_half(
      sample, [&](const Vec3f& wi) { return denser.evaluate(wo, wi).pdf; }, wo, peak)));
  // The Jacobian of reflection in place of refraction's, which eta^2 would make up for in f alone.
  EXPECT_TRUE(noticed(test_half(
      sample, [&](const Vec3f& wi) { return lobe.evaluate(wo, wi).pdf / (1.5f * 1.5f); }, wo, peak)));
}

/// The share of a white furnace that comes back to wo: light in the far medium has eta^2 times the radiance.
template <class Bsdf>
RunningStatistics furnace(const Bsdf& evaluate_sample, float eta, int samples) {
  Rng rng(testing::run_seed(5), 2);
  RunningStatistics energy;
  for (int i = 0; i < testing::run_samples(samples); ++i) {
    const auto [f_cos_over_pdf, below] = evaluate_sample(rng);
    energy.add(double(f_cos_over_pdf) * (below ? double(eta) * double(eta) : 1));
  }
  return energy;
}

struct Weight {
  float weight = 0;
  bool below = false;
};

template <class Lobe>
RunningStatistics lobe_furnace(const Lobe& lobe, const Vec3f& wo, float eta) {
  return furnace(
      [&](Rng& rng) -> Weight {
        const float u = rng.uniform();
        const auto wi = lobe.sample(wo, u, uniform2(rng));
        if (!wi) return {};
        const LobeValue value = lobe.evaluate(wo, *wi);
        return {value.f.g * std::abs(wi->z) / value.pdf, wi->z < 0};
      },
      eta, 40000);
}

// A lossless boundary: all of the light where it is smooth; less by what facets hide from each other where it is rough.
TEST(TransmissionFurnace, ClearBoundaries) {
  std::printf("%-34s", "white furnace at degrees");
  const double angles[] = {0, 38, 60, 80, 89};
  for (const double angle : angles) std::printf("%9.0f", angle);
  std::printf("\n");
  for (const float eta : {1.5f, 1 / 1.5f, 1.1f})
    for (const float alpha : {kMinAlpha, 0.01f, 0.25f, 1.0f}) {
      std::printf("solid, eta %.3f alpha %-14.4f", double(eta), double(alpha));
      for (const double angle : angles) {
        const DisneyDielectric lobe{{eta, Rgb(1.0f), Rgb(1.0f)}, {alpha, alpha}};
        const auto energy = lobe_furnace(lobe, at_angle(angle), eta);
        std::printf("%9.4f", energy.mean());
        EXPECT_LE(energy.mean(), 1 + 1e-4) << eta << " " << alpha << " at " << angle;
        EXPECT_LE(energy.max(), 1 + 2e-3) << "f cos / pdf is G1(wi)";
        EXPECT_GE(energy.mean(), alpha == kMinAlpha ? 1 - 2e-3 : 0) << eta << " at " << angle;
      }
      std::printf("\n");
    }
  for (const float alpha : {0.01f, 0.25f, 1.0f}) {
    const DisneyThinDielectric sheet{{1.5f, Rgb(1.0f), Rgb(1.0f)}, {alpha, alpha}, {alpha, alpha}};
    for (const double angle : angles) {
      const auto energy = lobe_furnace(sheet, at_angle(angle), 1);
      EXPECT_TRUE(plausible(at_most_test(energy, 1))) << alpha << " at " << angle;
      EXPECT_GE(energy.mean(), alpha == 0.01f && angle < 85 ? 1 - 2e-3 : 0) << alpha << " at " << angle;
    }
  }
}

// By samples and by quadrature over both sides, a blend of everything.
TEST(TransmissionFurnace, WholeBsdfBySamplesEqualsQuadrature) {
  for (const bool thin : {false, true})
    for (const double angle : {20.0, 80.0}) {
      DisneyParameters p = half_clear();
      p.thin = thin;
      const Vec3f wo = at_angle(angle);
      const DisneyTransmissiveBsdf bsdf(p, wo, {1.5f, false});
      const auto energy = furnace(
          [&](Rng& rng) -> Weight {
            const float u_lobe = rng.uniform();
            const auto s = bsdf.sample(u_lobe, uniform2(rng));
            if (!s || s->lobe == Lobe::subsurface) return {};
            return {s->weight().g, false};
          },
          1, 100000);
      const auto integrate = [&](Half half) {
        const Frame frame = frame_from_normal(peak_of(wo, half, thin ? 1 : 1.5f));
        const auto f_cos = [&](const Vec3f& wi) { return lies_in(wi, half) ? double(bsdf.evaluate(wi).f_cos.g) : 0.0; };
        return testing::integrate_sphere(f_cos, frame, 2);
      };
      const auto result = z_test(energy, integrate(Half::reflected) + integrate(Half::passed), {.slack = 1e-4});
      EXPECT_TRUE(plausible(result)) << thin << " at " << angle;
    }
}

}  // namespace
}  // namespace alabaster
