// Coat, fibres and films over what light passes: sheets, and interfaces of solids.
#include "core/material/disney_layers.h"

#include <gtest/gtest.h>

#include "core/material/disney_transmissive_bsdf.h"
#include "testenv/support/chi_square.h"
#include "testenv/support/material_testing.h"
#include "testenv/support/z_test.h"

namespace alabaster {
namespace {

using testing::RunningStatistics;
using testing::uniform2;

constexpr EnergyModel kModels[] = {EnergyModel::burley2015, EnergyModel::bounded, EnergyModel::conserving};

Vec3f at_degrees(float degrees, float phi = 0.3f) {
  const float theta = degrees * kPi / 180;
  return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

Vec3f below(const Vec3f& w) {
  return {w.x, w.y, -w.z};
}

Rgb random_color(Rng& rng) {
  const float r = rng.uniform(), g = rng.uniform();
  return {r, g, rng.uniform()};
}

/// A surface that light passes, under one or more layers.
DisneyParameters layered(Rng& rng) {
  DisneyParameters p;
  p.base_color = random_color(rng);
  p.diff_trans_color = random_color(rng);
  p.roughness = lerp(0.2f, 1.0f, rng.uniform());
  p.anisotropic = rng.next() % 2 ? rng.uniform() : 0;
  p.metallic = rng.next() % 2 ? rng.uniform() : 0;
  p.specular = rng.uniform();
  p.thin = rng.next() % 2;
  if (rng.next() % 3) p.spec_trans = rng.next() % 3 ? rng.uniform() : 1;
  if (rng.next() % 3) p.diff_trans = 2 * rng.uniform();
  const uint32_t kinds = rng.next();
  if (kinds & 1) {
    p.coat = rng.next() % 2 ? rng.uniform() : 1;
    p.coat_roughness = rng.uniform();
    p.coat_normal = normalize(Vec3f(0.3f * rng.uniform(), 0.3f * rng.uniform(), 1));
    p.coat_ior = 1 + rng.uniform();
    p.coat_color = random_color(rng);
    p.coat_darkening = rng.next() % 2 ? rng.uniform() : 0;
  }
  if (kinds & 2 || !(kinds & 1)) {
    p.sheen = rng.next() % 2 ? rng.uniform() : 1;
    p.sheen_color = random_color(rng);
    p.sheen_roughness = lerp(0.1f, 1.0f, rng.uniform());
  }
  if (kinds & 4) p.iridescence = rng.uniform(), p.iridescence_thickness = 800 * rng.uniform();
  if (kinds & 8) p.clearcoat = rng.uniform();
  return p;
}

/// The material as it is seen from the other side of the surface.
DisneyParameters turned_over(DisneyParameters p) {
  p.coat_normal = {-p.coat_normal.x, -p.coat_normal.y, p.coat_normal.z};
  return p;
}

struct Pair {
  Vec3f wo, wi;
};

/// f that a coat with a normal of its own adds to reflected light.
float coat_share(const DisneyParameters& p, const InterfaceSide& side, const Vec3f& wo, const Vec3f& wi) {
  const auto layers = side.inside ? std::nullopt : DisneyLayers::of(p);
  return layers && layers->coated() ? testing::f_of(layers->coat.evaluate(wo, wi), wi).g : 0;
}

// f(wo, wi) / n_o^2 = f(wi, wo) / n_i^2, as in DisneyTransmissiveBsdf.Reciprocity. Diffuse light knows no index: there
// the ratio is 1, so a surface has either lobe alone. A tilted coat is reciprocal with the cosine to its own normal
// (ATiltedCoatIsReciprocalAboutItsOwnNormal), so it is left out here.
void expect_reciprocal(const DisneyParameters& p, float eta, const Pair& w, EnergyModel energy) {
  const InterfaceSide outside{eta, false}, inside{p.thin ? eta : 1 / eta, !p.thin};
  const DisneyParameters back = turned_over(p);
  const auto seen = [&](const DisneyParameters& q, const InterfaceSide& side, const Vec3f& wo, const Vec3f& wi) {
    return testing::f_of(DisneyTransmissiveBsdf(q, wo, side, energy).evaluate(wi), wi).g;
  };
  const auto expect_same = [&](const DisneyParameters& q, const InterfaceSide& side) {
    const float one = seen(q, side, w.wo, w.wi), other = seen(q, side, w.wi, w.wo);
    const float coat = coat_share(q, side, w.wo, w.wi), other_coat = coat_share(q, side, w.wi, w.wo);
    EXPECT_NEAR(one - coat, other - other_coat, 1e-3f * (one - coat) + 1e-5f * (one + other) + 1e-6f);
  };
  expect_same(p, outside);
  expect_same(back, inside);
  const float n2 = p.thin || p.spec_trans == 0 ? 1 : eta * eta;
  const float passed = n2 * seen(p, outside, w.wo, below(w.wi)), again = seen(back, inside, w.wi, below(w.wo));
  EXPECT_NEAR(passed, again, 2e-3f * again + 1e-4f);
}

TEST(DisneyLayers, TransmissionOfSheetsAndInterfacesIsReciprocal) {
  Rng rng(testing::run_seed(81), 1);
  for (int i = 0; i < 30000 && !::testing::Test::HasFailure(); ++i) {
    DisneyParameters p = layered(rng);
    if (p.spec_trans > 0) p.diff_trans = 0;
    const float eta = p.thin ? p.ior : 1.05f + 0.9f * rng.uniform();
    const Pair w{sample_cosine_hemisphere(uniform2(rng)), sample_cosine_hemisphere(uniform2(rng))};
    if (w.wo.z < 0.02f || w.wi.z < 0.02f) continue;
    SCOPED_TRACE(i);
    // Bounds of anisotropic facets take a table for each shape.
    expect_reciprocal(p, eta, w, p.anisotropic > 0 ? EnergyModel::burley2015 : kModels[rng.next() % 3]);
  }
}

/// A coat whose normal leans by `degrees` against the other lobes' one, which a normal map has tilted.
DisneyParameters tilted_coat(float degrees, float roughness) {
  DisneyParameters p;
  p.coat = 1, p.coat_roughness = roughness;
  p.coat_normal = p.surface_normal = at_degrees(degrees, 1);
  return p;
}

TEST(DisneyLayers, ATiltedCoatIsReciprocalAboutItsOwnNormal) {
  Rng rng(testing::run_seed(81), 6);
  int seen = 0;
  for (int i = 0; i < 10000; ++i) {
    const DisneyParameters p = tilted_coat(60 * rng.uniform(), lerp(0.2f, 1.0f, rng.uniform()));
    const DisneyCoat coat = DisneyLayers::of(p)->coat;
    const auto of_lobe = [&](const Vec3f& wo, const Vec3f& wi) {
      return coat.evaluate(wo, wi).f_cos.g / dot(wi, p.coat_normal);
    };
    const Vec3f wo = sample_cosine_hemisphere(uniform2(rng)), wi = sample_cosine_hemisphere(uniform2(rng));
    if (std::min(dot(wo, p.coat_normal), dot(wi, p.coat_normal)) < 0.02f || std::min(wo.z, wi.z) < 0.02f) continue;
    const float f = of_lobe(wo, wi);
    seen += f > 0;
    ASSERT_NEAR(f, of_lobe(wi, wo), 1e-3f * f) << i;
  }
  EXPECT_GT(seen, 5000);
}

/// What a coat leaves of light that comes back from below: OpenPBR 1.1.1, "Coat".
std::array<double, 3> left_by_coat(const DisneyParameters& p) {
  const double n = double(p.coat_ior), f0 = std::pow((n - 1) / (n + 1), 2), k = 1 - (1 - f0) / (n * n);
  std::array<double, 3> left{};
  for (int c = 0; c < 3; ++c) {
    const double b = double(p.base_color[c]), a = double(p.subsurface_color.r >= 0 ? p.subsurface_color[c] : b),
                 w = p.thin ? 0 : double(p.subsurface_weight), dielectric = b + (a - b) * w,
                 e = dielectric + (b - dielectric) * double(p.metallic);
    const double darkened = 1 + ((1 - k) / (1 - e * k) - 1) * double(p.coat) * double(p.coat_darkening);
    left[size_t(c)] = (1 + (double(p.coat_color[c]) - 1) * double(p.coat)) * darkened;
  }
  return left;
}

void expect_times(const Rgb& stained, const Rgb& clear, const std::array<double, 3>& left, double power) {
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(double(stained[c]), double(clear[c]) * std::pow(left[size_t(c)], power), 1e-5 * double(clear[c]) + 1e-6)
        << c;
}

TEST(DisneyLayers, ACoatTakesARootOfItsColourAndDarkeningEachTimeThatLightPasses) {
  Rng rng(testing::run_seed(81), 9);
  for (int i = 0; i < 2000 && !::testing::Test::HasFailure(); ++i) {
    DisneyParameters stained = layered(rng);
    stained.coat = rng.next() % 2 ? 1 : rng.uniform();
    stained.coat_normal = Vec3f(0, 0, 1);
    stained.clearcoat = 0;
    if (rng.next() % 2) stained.subsurface_weight = rng.uniform(), stained.subsurface_color = random_color(rng);
    const auto left = left_by_coat(stained);
    DisneyParameters clear = stained;
    clear.coat_color = Rgb(1.0f), clear.coat_darkening = 0;
    const Vec3f wo = at_degrees(80 * rng.uniform()), wi = at_degrees(80 * rng.uniform(), 2);
    const DisneyBsdf a(stained, wo), b(clear, wo);
    const Rgb coat = DisneyLayers::of(clear)->coat.evaluate(wo, wi).f_cos;
    expect_times(a.evaluate(wi).f_cos - coat, b.evaluate(wi).f_cos - coat, left, 1);
    stained.scatter_distance = clear.scatter_distance = Rgb(1.0f);
    if (!stained.thin)
      expect_times(DisneyBsdf(stained, wo).subsurface_entry(), DisneyBsdf(clear, wo).subsurface_entry(), left, 0.5);
    stained.scatter_distance = clear.scatter_distance = Rgb(0.0f);
    const InterfaceSide side{1.5f, !stained.thin && rng.next() % 2};
    const DisneyTransmissiveBsdf through(stained, wo, side), as_clear(clear, wo, side);
    expect_times(through.evaluate(below(wi)).f_cos, as_clear.evaluate(below(wi)).f_cos, left, stained.thin ? 1 : 0.5);
  }
}

TEST(DisneyLayers, AWhiteCoatOfIndexOneIsNone) {
  Rng rng(testing::run_seed(81), 10);
  for (int i = 0; i < 5000 && !::testing::Test::HasFailure(); ++i) {
    DisneyParameters coated = layered(rng);
    coated.coat = 1, coated.coat_ior = 1, coated.coat_color = Rgb(1.0f), coated.coat_darkening = rng.uniform();
    coated.clearcoat = 0, coated.anisotropic = 0;
    DisneyParameters bare = coated;
    bare.coat = 0;
    const InterfaceSide side{1.5f, !coated.thin && rng.next() % 2};
    const EnergyModel energy = kModels[rng.next() % 3];
    const Vec3f wo = at_degrees(85 * rng.uniform());
    for (const Vec3f& wi : {at_degrees(85 * rng.uniform(), 2), below(at_degrees(85 * rng.uniform(), 2))}) {
      const Rgb a = DisneyTransmissiveBsdf(coated, wo, side, energy).evaluate(wi).f_cos,
                b = DisneyTransmissiveBsdf(bare, wo, side, energy).evaluate(wi).f_cos;
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], 1e-4f * b[c] + 1e-7f) << i;
    }
  }
}

/// The share of light from `wi`, on the upper side, that a sheet sends on to both sides.
RunningStatistics sent_on(const DisneyParameters& p, const Vec3f& wi, EnergyModel energy, Rng& rng) {
  RunningStatistics share;
  for (int i = 0; i < testing::run_samples(20000); ++i) {
    const Vec3f wo = sample_cosine_hemisphere(uniform2(rng));
    const DisneyTransmissiveBsdf bsdf(p, wo, {p.ior, false}, energy);
    share.add(double(max_component(bsdf.evaluate(wi).f_cos + bsdf.evaluate(below(wi)).f_cos) * (kPi / wi.z)));
  }
  return share;
}

/// The share of white light from everywhere that a viewer at `wo` sees, of the brightest channel.
RunningStatistics seen_of(const DisneyTransmissiveBsdf& bsdf, Rng& rng) {
  RunningStatistics share;
  for (int i = 0; i < testing::run_samples(20000); ++i) {
    const float u_lobe = rng.uniform();
    const auto sample = bsdf.sample(u_lobe, uniform2(rng));
    share.add(sample ? double(sample->weight().g) : 0);
  }
  return share;
}

DisneyParameters white_sheet(float diff_trans) {
  DisneyParameters p;
  p.base_color = p.diff_trans_color = Rgb(1.0f);
  p.specular = 0;
  p.diff_trans = diff_trans;
  p.thin = true;
  return p;
}

// Before, a sheet under fibres sent on 1.53 of the light that grazes it.
TEST(DisneyLayers, ASheetSendsOnNoMoreLightThanItGets) {
  Rng rng(testing::run_seed(81), 2);
  for (const float diff_trans : {1.0f, 2.0f})
    for (const bool coated : {true, false})
      for (const float roughness : {0.1f, 0.4f, 0.8f})
        for (const float degrees : {0.0f, 60.0f, 85.0f}) {
          DisneyParameters p = white_sheet(diff_trans);
          p.coat = coated ? 1 : 0, p.sheen = coated ? 0 : 1;
          p.coat_roughness = p.sheen_roughness = roughness;
          const auto to_lights = sent_on(p, at_degrees(degrees), EnergyModel::bounded, rng);
          EXPECT_TRUE(plausible(testing::at_most_test(to_lights, 1.01)))
              << diff_trans << coated << " roughness " << roughness << " at " << degrees;
          const auto to_viewers = seen_of({p, at_degrees(degrees), {p.ior, false}, EnergyModel::bounded}, rng);
          EXPECT_TRUE(plausible(testing::at_most_test(to_viewers, 1.01))) << roughness << " at " << degrees;
        }
}

TEST(DisneyLayers, ClearSheetsAndInterfacesUnderLayersSendOnNoMoreThanTheyGet) {
  Rng rng(testing::run_seed(81), 3);
  for (int i = 0; i < 300; ++i) {
    DisneyParameters p = layered(rng);
    p.base_color = p.diff_trans_color = p.sheen_color = Rgb(1.0f);
    p.iridescence = 0, p.anisotropic = 0, p.coat_normal = Vec3f(0, 0, 1);
    p.spec_trans = std::max(p.spec_trans, 0.5f);
    const bool inside = !p.thin && rng.next() % 2;
    const Vec3f wo = at_degrees(89 * rng.uniform());
    // The index is equal on both sides of a solid: light that crosses into another medium has its radiance scaled.
    const auto seen = seen_of({p, wo, {p.thin ? p.ior : 1.0f, inside}, EnergyModel::bounded}, rng);
    EXPECT_TRUE(plausible(testing::at_most_test(seen, 1.01))) << i << " at " << wo.z << " inside " << inside;
  }
}

/// One sample of the light that is reflected to a viewer, where it comes from the upper sides of the surface and of
/// `normal`.
struct Reflected {
  double share = 0;
  Vec3f wi{0, 0, 1};
};
Reflected reflected(const DisneyTransmissiveBsdf& bsdf, const Vec3f& normal, Rng& rng) {
  const float u_lobe = rng.uniform();
  const auto s = bsdf.sample(u_lobe, uniform2(rng));
  const bool stays = s && s->lobe != Lobe::straight && dot(s->wi, normal) > 0 && bsdf.reflects_to(s->wi);
  return stays ? Reflected{double(s->weight().g), s->wi} : Reflected();
}

/// A viewer at `wo` sees in the coat over the tilted base what one at `over_flat` sees over a flat black base.
///
/// A clear boundary below the coat adds its own reflection. The coat lets no more of it pass than it lets light pass
/// towards the viewer: a bound by energy. It lets no more pass than it has let in either.
void expect_as_over_flat_base(const DisneyParameters& p, const Vec3f& wo, const Vec3f& over_flat, Rng& rng) {
  const Vec3f up(0, 0, 1);
  DisneyParameters flat = p, bare = p;
  flat.coat_normal = flat.surface_normal = bare.coat_normal = bare.surface_normal = up;
  flat.spec_trans = flat.specular = bare.coat = 0;
  constexpr InterfaceSide kOutside{1.5f, false};
  const DisneyTransmissiveBsdf tilted(p, wo, kOutside, EnergyModel::bounded);
  const DisneyTransmissiveBsdf coat_alone(flat, over_flat, kOutside, EnergyModel::bounded);
  const DisneyTransmissiveBsdf boundary_alone(bare, wo, kOutside, EnergyModel::bounded);
  const DisneyCoat coat = DisneyLayers::of(p)->coat;
  RunningStatistics seen, expected, of_coat, above_bound;
  for (int i = 0; i < testing::run_samples(20000); ++i) {
    const double one = reflected(tilted, p.coat_normal, rng).share, by_coat = reflected(coat_alone, up, rng).share;
    const Reflected below = reflected(boundary_alone, p.coat_normal, rng);
    const double out = double(coat.passed(wo)), in = double(coat.passed(below.wi));
    seen.add(one);
    of_coat.add(by_coat);
    expected.add(by_coat + below.share * std::min(in, out));
    above_bound.add(one - by_coat - below.share * out);
  }
  EXPECT_GT(of_coat.mean(), 0.03);
  EXPECT_EQ(expected.mean() > of_coat.mean(), p.spec_trans > 0) << "the boundary's reflection";
  EXPECT_TRUE(plausible(z_test(seen, expected, {.slack = 4e-4})));
  EXPECT_TRUE(plausible(testing::at_most_test(above_bound, 4e-4)));
}

// Before, light on the coat counted by the cosine to the base's normal: 13 % less at a tilt of 30 degrees, and none
// below the base's horizon.
TEST(DisneyLayers, ACoatOverATiltedBaseReflectsWhatItDoesOverAFlatOne) {
  Rng rng(testing::run_seed(81), 7);
  for (const bool clear : {false, true})
    for (const float roughness : {0.02f, 0.3f})
      for (const float view : {0.0f, 30.0f, 60.0f})
        for (const float tilt : {30.0f, 55.0f, -25.0f}) {
          // The tilt is within the plane of the view, where it changes the cosines most.
          DisneyParameters p = tilted_coat(tilt, roughness);
          p.base_color = p.specular_color = Rgb(0.0f), p.specular = 0;
          if (clear) p.spec_trans = p.specular = 1, p.specular_color = Rgb(1.0f);
          const Frame surface = frame_from_normal_tangent(p.coat_normal, {std::cos(1.0f), std::sin(1.0f), 0});
          const Vec3f wo = surface.to_world(at_degrees(view, 0));
          if (wo.z < 0.05f) continue;
          SCOPED_TRACE(std::to_string(clear) + " roughness " + std::to_string(roughness) + " at " +
                       std::to_string(view) + ", " + std::to_string(tilt));
          expect_as_over_flat_base(p, wo, at_degrees(view, 0), rng);
        }
}

TEST(DisneyLayers, AWhiteBaseUnderATiltedCoatSendsOnNoMoreThanItGets) {
  Rng rng(testing::run_seed(81), 8);
  for (const float tilt : {15.0f, 40.0f, 60.0f})
    for (const float roughness : {0.05f, 0.5f})
      for (const float metallic : {0.0f, 1.0f})
        for (const float view : {0.0f, 50.0f, 80.0f}) {
          DisneyParameters p = tilted_coat(tilt, roughness);
          p.base_color = Rgb(1.0f);
          p.metallic = metallic;
          for (const float turn : {1.0f, 4.0f}) {
            const Vec3f wo = at_degrees(view, turn);
            if (dot(wo, p.coat_normal) < 0.02f) continue;
            const DisneyTransmissiveBsdf bsdf(p, wo, {1.5f, false}, EnergyModel::bounded);
            EXPECT_TRUE(plausible(testing::at_most_test(seen_of(bsdf, rng), 1.01)))
                << tilt << " roughness " << roughness << " metallic " << metallic << " at " << view << ", " << turn;
          }
        }
}

// Light that the layers do not let out of a solid comes back into it: coated glass in a furnace is not seen.
TEST(DisneyLayers, SmoothGlassUnderLayersLosesNothing) {
  Rng rng(testing::run_seed(81), 4);
  for (const bool coated : {true, false})
    for (const bool inside : {true, false})
      for (const float degrees : {0.0f, 30.0f, 41.0f, 60.0f, 80.0f}) {
        DisneyParameters p;
        p.base_color = Rgb(1.0f);
        p.spec_trans = 1;
        p.roughness = 0.02f;
        p.coat = coated ? 1 : 0, p.sheen = coated ? 0 : 1;
        p.coat_roughness = 0.02f, p.sheen_roughness = 0.5f;
        const float eta = inside ? 1 / 1.5f : 1.5f;
        const DisneyTransmissiveBsdf bsdf(p, at_degrees(degrees), {eta, inside}, EnergyModel::bounded);
        RunningStatistics share;
        for (int i = 0; i < testing::run_samples(20000); ++i) {
          const float u_lobe = rng.uniform();
          const auto s = bsdf.sample(u_lobe, uniform2(rng));
          // Radiance that enters a medium is larger by its index squared.
          share.add(s ? double(s->weight().g * (s->wi.z < 0 ? eta * eta : 1)) : 0);
        }
        EXPECT_TRUE(plausible(z_test(share, 1, {.slack = 6e-3}))) << coated << inside << " at " << degrees;
      }
}

// Diffuse light that comes to the layers from inside a solid, and does not pass them, goes back in.
TEST(DisneyLayers, SolidsThatDiffuseLightPassesLoseNothingBelowLayers) {
  Rng rng(testing::run_seed(81), 5);
  for (const int layers : {1, 2, 3})
    for (const float degrees : {0.0f, 60.0f, 85.0f}) {
      DisneyParameters p = white_sheet(2);
      p.thin = false;
      p.coat = layers & 1 ? 1.0f : 0.0f, p.sheen = layers & 2 ? 1.0f : 0.0f;
      p.coat_roughness = 0.3f, p.sheen_roughness = 0.5f;
      const DisneyTransmissiveBsdf bsdf(p, at_degrees(degrees), {1, true}, EnergyModel::burley2015);
      const auto seen = seen_of(bsdf, rng);
      EXPECT_TRUE(plausible(z_test(seen, 1, {.slack = 3e-3}))) << layers << " at " << degrees;
      // Samples and evaluation are of one function.
      RunningStatistics evaluated;
      for (int i = 0; i < testing::run_samples(20000); ++i) {
        const Vec3f wi = sample_cosine_hemisphere(uniform2(rng));
        evaluated.add(double(bsdf.evaluate(wi).f_cos.g + bsdf.evaluate(below(wi)).f_cos.g) * double(kPi / wi.z));
      }
      EXPECT_TRUE(plausible(z_test(evaluated, seen, {.slack = 1e-3})));
    }
}

DisneyParameters filmed(float metallic, float specular, float ior) {
  DisneyParameters p;
  p.base_color = Rgb(0.6f, 0.3f, 0.1f);
  p.metallic = metallic;
  p.specular = specular;
  p.ior = ior;
  p.iridescence = 1;
  return p;
}

/// Reflectance of the facets of an opaque surface, and of a clear one from outside and from inside.
std::array<Rgb, 3> reflectances(DisneyParameters p, float cosine) {
  const Rgb opaque = DisneySpecular::from(p).fresnel(cosine);
  p.spec_trans = 1;
  const auto clear = [&](float eta, bool inside) {
    return DielectricBoundary::from(p, eta, Rgb(1.0f), inside).shares(cosine).reflected;
  };
  return {opaque, clear(p.ior, false), clear(1 / p.ior, true)};
}

float largest_difference(const std::array<Rgb, 3>& a, const std::array<Rgb, 3>& b) {
  float largest = 0;
  for (size_t i = 0; i < a.size(); ++i)
    for (int c = 0; c < 3; ++c) largest = std::max(largest, std::abs(a[i][c] - b[i][c]));
  return largest;
}

// A film of thickness 0 more than doubled the reflectance at 75 degrees.
TEST(DisneyLayers, AFilmWithoutThicknessOrOfTheIndexOfAirIsNone) {
  for (const float metallic : {0.0f, 0.5f, 1.0f})
    for (const float specular : {1.0f, 0.4f})
      for (const float ior : {1.1f, 1.5f, 2.5f})
        for (const float degrees : {0.0f, 45.0f, 75.0f, 85.0f, 89.0f}) {
          DisneyParameters bare = filmed(metallic, specular, ior), thin = bare, air = bare;
          bare.iridescence = 0;
          thin.iridescence_thickness = 0;
          air.iridescence_ior = 1;
          const float cosine = std::cos(degrees * kPi / 180);
          const auto none = reflectances(bare, cosine);
          EXPECT_EQ(largest_difference(none, reflectances(thin, cosine)), 0) << degrees;
          EXPECT_EQ(largest_difference(none, reflectances(air, cosine)), 0) << degrees;
          const Vec3f wo = at_degrees(degrees), wi = at_degrees(60, 2);
          for (const EnergyModel energy : kModels)
            EXPECT_EQ(DisneyBsdf(thin, wo, energy).evaluate(wi).f_cos, DisneyBsdf(bare, wo, energy).evaluate(wi).f_cos);
        }
}

TEST(DisneyLayers, AFilmFadesContinuouslyAsItsThicknessAndItsIndexDo) {
  for (const float metallic : {0.0f, 1.0f})
    for (const float specular : {1.0f, 0.4f})
      for (const float degrees : {0.0f, 45.0f, 75.0f, 85.0f}) {
        const float cosine = std::cos(degrees * kPi / 180);
        DisneyParameters p = filmed(metallic, specular, 1.5f);
        p.iridescence = 0;
        auto last = reflectances(p, cosine);
        p.iridescence = 1;
        // A film refracts grazing light as soon as it is denser than air.
        const float step = degrees > 80 ? 0.07f : 0.02f;
        for (int i = 1; i <= 80; ++i) {
          p.iridescence_thickness = 0.5f * float(i);
          const auto next = reflectances(p, cosine);
          EXPECT_LT(largest_difference(last, next), step) << p.iridescence_thickness << " nm at " << degrees;
          last = next;
        }
        p.iridescence_thickness = 1e-3f;
        p.iridescence = 0;
        last = reflectances(p, cosine);
        p.iridescence = 1;
        EXPECT_LT(largest_difference(last, reflectances(p, cosine)), 1e-4f) << degrees;
        p.iridescence_thickness = 300;
        for (int i = 1; i <= 60; ++i) {
          p.iridescence_ior = 1 + 0.005f * float(i);
          const auto next = reflectances(p, cosine);
          EXPECT_LT(largest_difference(last, next), 2 * step) << p.iridescence_ior << " at " << degrees;
          last = next;
        }
      }
}

}  // namespace
}  // namespace alabaster
