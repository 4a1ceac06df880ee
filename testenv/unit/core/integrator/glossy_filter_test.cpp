// Pictures with filtered gloss.
#include <gtest/gtest.h>

#include "core/integrator/vertex.h"
#include "core/material/disney_transmissive_bsdf.h"
#include "testenv/support/path_tracer.h"
#include "testenv/support/scene_builder.h"
#include "testenv/support/z_test.h"

namespace alabaster {
namespace {

using testing::PathTracer;
using testing::SceneBuilder;

DisneyParameters metal(float roughness) {
  DisneyParameters p;
  p.base_color = Rgb(0.9f);
  p.metallic = 1;
  p.roughness = roughness;
  return p;
}

// The camera sees a matt floor beside a ball of metal, on which the light of a small bright sphere falls.
std::shared_ptr<const SceneSnapshot> floor_and_ball(const DisneyParameters& ball, const DisneyParameters& floor) {
  SceneBuilder b;
  b.add(b.prototype(testing::sphere_mesh(1, 24, true)), b.material(ball), Matrix4d().setTranslation(Vec3d(0, 1, -1.2)));
  LightParameters light;
  light.type = LightType::sphere;
  light.color = Rgb(200.0f);
  light.radius = 0.1f;
  light.light_to_world = Matrix4d().setTranslation(Vec3d(0, 3, 4));
  b.add(b.prototype(testing::plane_mesh(20)), b.material(floor)).add(light);
  return b.snapshot();
}

testing::RunningStatistics radiance(const std::shared_ptr<const SceneSnapshot>& scene, float filter,
                                    uint32_t max_depth = 8, uint32_t samples = 20000) {
  PathTracer tracer(scene, {0.3, 4, 4});
  tracer.settings.glossy_filter = filter;
  tracer.settings.max_depth = max_depth;
  testing::RunningStatistics statistics;
  for (uint32_t i = 0; i < testing::run_samples(samples); ++i) statistics.add(double(tracer.trace(i).color.g));
  return statistics;
}

TEST(GlossyFilter, ReducesTheNoiseOfCaustics) {
  const auto scene = floor_and_ball(metal(0.1f), testing::matt(Rgb(0.5f)));
  const auto sharp = radiance(scene, 0, 8, 800000), filtered = radiance(scene, 1, 8, 100000);
  EXPECT_LT(filtered.variance(), sharp.variance() / 10) << sharp.variance();
  // A blur: a few per cent. Lobes that do not keep their albedo lose twelve.
  EXPECT_TRUE(plausible(z_test(filtered, sharp, {.slack = 0.03 * sharp.mean()})));
  EXPECT_LT(sharp.standard_error(), 0.015 * sharp.mean()) << "or the comparison proves nothing";
}

// promise: trade_off.bias.glossy_filter
TEST(GlossyFilter, LeavesWhatTheCameraSeesDirectlyOrInMirrors) {
  const auto matt = testing::matt(Rgb(0.5f));
  const auto same = [](const std::shared_ptr<const SceneSnapshot>& scene, uint32_t max_depth) {
    const auto sharp = radiance(scene, 0, max_depth), filtered = radiance(scene, 1, max_depth);
    return sharp.mean() == filtered.mean() && sharp.variance() == filtered.variance();
  };
  EXPECT_TRUE(same(floor_and_ball(matt, matt), 8));
  EXPECT_TRUE(same(floor_and_ball(matt, metal(0.1f)), 1));
  EXPECT_FALSE(same(floor_and_ball(metal(0.1f), matt), 8));
}

// promise: trade_off.bias.glossy_filter
TEST(GlossyFilter, WidensByTheSpreadOfTheBundle) {
  Footprint footprint;
  footprint.scatter(std::numeric_limits<float>::infinity());  // a mirror
  EXPECT_EQ(footprint.least_alpha(), 0);
  footprint.scatter(1 / kPi);  // a matt surface: the bundle is a projected hemisphere, pi
  EXPECT_NEAR(footprint.least_alpha(), 0.5f, 1e-6f);
  // GGX of that alpha reflects along its normal with density 1 / (4 pi alpha^2) = 1 / pi.
  DisneyParameters p = metal(0);
  p.least_roughness = std::sqrt(footprint.least_alpha());
  const DisneyBsdf bsdf(p, {0, 0, 1});
  EXPECT_NEAR(bsdf.evaluate({0, 0, 1}).pdf, 1 / kPi, 0.01f);
}

// A least roughness below a lobe's own changes nothing, and one above it changes no diffuse lobe.
TEST(GlossyFilter, NarrowsNothingAndLeavesTheDiffuseLobe) {
  DisneyParameters p;
  p.clearcoat = 1;
  p.clearcoat_gloss = 0.5f;
  p.roughness = 0.6f;
  DisneyParameters widened = p;
  widened.least_roughness = 0.2f;
  const Vec3f wo = normalize(Vec3f(0.4f, 0, 0.8f)), wi = normalize(Vec3f(-0.5f, 0.1f, 0.7f));
  const auto f = [&](const DisneyParameters& parameters, Rgb* specular) {
    return DisneyBsdf(parameters, wo).evaluate(wi, specular).f_cos;
  };
  Rgb before, after;
  EXPECT_EQ(f(p, &before), f(widened, &after));
  widened.least_roughness = 0.9f;
  const Rgb diffuse = f(p, &before) - before;
  EXPECT_NEAR((f(widened, &after) - after).g, diffuse.g, 1e-6f);
  EXPECT_NE(before, after);
}

// Under a white sky a widened lobe is as bright as the material's own, also where it grazes.
TEST(GlossyFilter, KeepsTheDirectionalAlbedo) {
  for (const float metallic : {0.0f, 1.0f})
    for (const float cosine : {0.15f, 0.5f, 0.95f}) {
      DisneyParameters p = metal(0.05f);
      p.metallic = metallic;
      p.base_color = Rgb(metallic > 0 ? 0.9f : 0.0f);
      const Vec3f wo(std::sqrt(1 - cosine * cosine), 0, cosine);
      const auto albedo = [&](float least_roughness) {
        p.least_roughness = least_roughness;
        const DisneyBsdf bsdf(p, wo);
        constexpr int kSide = 256;
        double sum = 0;
        for (int i = 0; i < kSide * kSide; ++i) {
          const float u = (static_cast<float>(i % kSide) + 0.5f) / kSide,
                      v = (static_cast<float>(i / kSide) + 0.5f) / kSide;
          const auto sample = bsdf.sample(0.5f, {u, v});
          if (sample) sum += double(sample->weight().g);
        }
        return sum / (kSide * kSide);
      };
      EXPECT_NEAR(albedo(0.7f) / albedo(0), 1, 0.02) << metallic << " " << cosine;
    }
}

// The share of white light along wo that `bsdf` sends to one side of the surface.
template <class Bsdf>
double sent(const Bsdf& bsdf, bool up) {
  constexpr int kSide = 256;
  double sum = 0;
  for (int i = 0; i < kSide * kSide; ++i) {
    const Vec2f u((static_cast<float>(i % kSide) + 0.5f) / kSide, (static_cast<float>(i / kSide) + 0.5f) / kSide);
    const float u_lobe = std::fmod(static_cast<float>(i) * 0.618034f, 1.0f);
    const auto sample = bsdf.sample(u_lobe, u);
    if (sample && (sample->wi.z > 0) == up) sum += double(sample->weight().g);
  }
  return sum / (kSide * kSide);
}

// Both ways together, seen from outside and from inside, where part of the directions reflect totally. Radiance that
// crosses into a medium is over eta^2.
TEST(GlossyFilter, KeepsTheAlbedoOfClearBoundaries) {
  for (const float roughness : {0.0f, 0.4f})
    for (const float eta : {1.5f, 1 / 1.5f, 1 / 1.33f})
      for (const float cosine : {0.3f, 0.6f, 0.95f}) {
        DisneyParameters p;
        p.base_color = Rgb(1.0f);
        p.spec_trans = 1;
        p.roughness = roughness;
        DisneyParameters widened = p;
        widened.least_roughness = 0.7f;
        const Vec3f wo(std::sqrt(1 - cosine * cosine), 0, cosine);
        const auto albedo = [&](const DisneyParameters& parameters) {
          const DisneyTransmissiveBsdf bsdf(parameters, wo, {eta, eta < 1});
          return sent(bsdf, true) + sent(bsdf, false) * eta * eta;
        };
        EXPECT_NEAR(albedo(widened), albedo(p), 0.02) << roughness << " " << eta << " " << cosine;
      }
}

TEST(GlossyFilter, KeepsTheAlbedoOfThinSheetsCoatAndClearcoat) {
  for (const float cosine : {0.2f, 0.5f, 0.95f}) {
    const Vec3f wo(std::sqrt(1 - cosine * cosine), 0, cosine);
    const auto widened = [](DisneyParameters p) {
      p.least_roughness = 0.7f;
      return p;
    };
    DisneyParameters sheet;
    sheet.base_color = Rgb(1.0f);
    sheet.spec_trans = 1, sheet.thin = true, sheet.roughness = 0.1f;
    const auto boundary = [&](const DisneyParameters& p) { return DisneyTransmissiveBsdf(p, wo, {1.5f, false}); };
    for (const bool up : {true, false})
      EXPECT_NEAR(sent(boundary(widened(sheet)), up) / sent(boundary(sheet), up), 1, 0.055) << cosine << up;
    DisneyParameters coated;
    coated.base_color = Rgb(0.0f);
    coated.specular = 0;
    coated.coat = 1;
    EXPECT_NEAR(sent(DisneyBsdf(widened(coated), wo), true) / sent(DisneyBsdf(coated, wo), true), 1, 0.03) << cosine;
    coated.coat = 0, coated.clearcoat = 1;
    EXPECT_NEAR(sent(DisneyBsdf(widened(coated), wo), true) / sent(DisneyBsdf(coated, wo), true), 1, 0.03) << cosine;
  }
}

// The reflectance under a film is defined for a base that reflects at most all light.
TEST(GlossyFilter, LeavesTheBaseUnderAFilmAsItIs) {
  DisneyParameters p = metal(0.05f);
  p.base_color = Rgb(1.0f);
  p.iridescence = 1;
  p.least_roughness = 0.8f;
  DisneyParameters rough = p;
  rough.roughness = 0.8f;
  rough.least_roughness = 0;
  const Vec3f wo = normalize(Vec3f(0.9f, 0, 0.2f)), wi = normalize(Vec3f(-0.8f, 0.1f, 0.3f));
  EXPECT_EQ(DisneyBsdf(p, wo).evaluate(wi).f_cos, DisneyBsdf(rough, wo).evaluate(wi).f_cos);
}

TEST(GlossyFilter, IsNotOfModeReference) {
  RenderSettings settings;
  settings.glossy_filter = 1;
  EXPECT_EQ(integrator_settings(settings).glossy_filter, 1);
  settings.subsurface = SubsurfaceMode::reference;
  EXPECT_EQ(integrator_settings(settings).glossy_filter, 0);
}

}  // namespace
}  // namespace alabaster
