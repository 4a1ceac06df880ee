#include "core/light/light_shaping.h"

#include <gtest/gtest.h>

#include "core/light/light.h"
#include "core/sampling/pixel_sampler.h"
#include "core/sampling/warp.h"

namespace alabaster {
namespace {

Vec3d at_degrees(double degrees) {
  const double a = degrees * kPiDouble / 180;
  return {std::sin(a), 0, -std::cos(a)};
}

double cosine(double degrees) {
  return std::cos(degrees * kPiDouble / 180);
}

LightParameters spot(float inner, float outer) {
  LightParameters d;
  d.cone_inner = inner;
  d.cone_outer = outer;
  return d;
}

Rgb factor(const LightParameters& d, double degrees) {
  const auto shaping = LightShaping::make(d);
  return shaping ? shaping->factor(at_degrees(degrees)) : Rgb(-1.0f);
}

// ((cos(angle) - cos(outer)) / (cos(inner) - cos(outer)))^2, clamped.
TEST(LightShaping, SpotsFollowKhrLightsPunctual) {
  EXPECT_EQ(factor(spot(20, 40), 0).g, 1);
  EXPECT_EQ(factor(spot(20, 40), 19.9).g, 1);
  EXPECT_EQ(factor(spot(20, 40), 40.1).g, 0);
  EXPECT_EQ(factor(spot(20, 40), 180).g, 0);
  const double ramp = (cosine(30) - cosine(40)) / (cosine(20) - cosine(40));
  EXPECT_NEAR(factor(spot(20, 40), 30).g, ramp * ramp, 1e-6);
  EXPECT_FALSE(LightShaping::make(spot(180, 180))) << "unshaped";
  EXPECT_EQ(factor(spot(50, 40), 39.9).g, 1) << "inner beyond outer: a hard edge";
  EXPECT_EQ(factor(spot(50, 40), 40.1).g, 0);
  // Narrow beams keep their shape: here cos differs from 1 by less than a float can say.
  EXPECT_EQ(factor(spot(0.01f, 0.02f), 0.005).g, 1);
  EXPECT_NEAR(factor(spot(0, 0.02f), 0.01).g, 0.5625, 1e-3);  // (1 - 1/4)^2: 1 - cos goes as the square of small angles
  EXPECT_EQ(factor(spot(0.01f, 0.02f), 0.021).g, 0);
}

// 1 - smoothstep(angle, lerp(softness, cutoff, 0), cutoff).
TEST(LightShaping, ConesFollowUsdLux) {
  LightParameters d;
  d.cone_angle = 40;
  EXPECT_EQ(factor(d, 39.9).g, 1);
  EXPECT_EQ(factor(d, 40.1).g, 0);
  d.cone_softness = 0.5f;
  EXPECT_EQ(factor(d, 19.9).g, 1);
  EXPECT_NEAR(factor(d, 30).g, 0.5, 1e-6);
  const double t = (25.0 - 20) / 20;
  EXPECT_NEAR(factor(d, 25).g, 1 - t * t * (3 - 2 * t), 1e-6);
  EXPECT_EQ(factor(d, 40.1).g, 0);
  d.cone_inner = d.cone_outer = 5;
  EXPECT_EQ(factor(d, 19.9).g, 1) << "replaces coneInner and coneOuter";
  d.cone_angle = 180;
  d.cone_softness = 1;
  EXPECT_NEAR(factor(d, 90).g, 0.5, 1e-6) << "soft over all directions";
}

// lerp(focusTint, white, |cos|^focus).
TEST(LightShaping, FocusFollowsUsdLux) {
  LightParameters d;
  d.focus = 3;
  EXPECT_NEAR(factor(d, 60).g, 0.125, 1e-6);
  EXPECT_NEAR(factor(d, 120).g, 0.125, 1e-6) << "behind as in front";
  d.focus_tint = Rgb(1, 0.5f, 0);
  const Rgb tinted = factor(d, 60);
  EXPECT_NEAR(tinted.r, 1, 1e-6);
  EXPECT_NEAR(tinted.g, 0.5625, 1e-6);
  EXPECT_NEAR(tinted.b, 0.125, 1e-6);
}

std::vector<LightParameters> some_shapings() {
  LightParameters usd = spot(180, 180), focus = usd, tinted = usd;
  usd.cone_angle = 50;
  usd.cone_softness = 0.7f;
  focus.focus = 8;
  tinted.focus = 2;
  tinted.focus_tint = Rgb(0.1f, 2, 3);
  tinted.cone_angle = 120;
  return {spot(20, 40), spot(0, 90), spot(30, 30), usd, focus, tinted};
}

TEST(LightShaping, MeanIsTheMeanOverTheSphere) {
  for (const LightParameters& d : some_shapings()) {
    const auto shaping = LightShaping::make(d);
    double sum = 0;
    constexpr int kSteps = 20000;
    for (int i = 0; i < kSteps; ++i) {
      const double z = -1 + 2 * (i + 0.5) / kSteps;
      sum += static_cast<double>(luminance(shaping->factor(Vec3d(std::sqrt(1 - z * z), 0, z))));
    }
    EXPECT_NEAR(shaping->mean(), sum / kSteps, 1e-3);
  }
}

TEST(LightShaping, LargestIsABound) {
  Rng rng(1, 1);
  const auto unit = [&] {
    const float x = rng.uniform();
    return normalize(Vec3d(sample_uniform_sphere({x, rng.uniform()})));
  };
  for (const LightParameters& d : some_shapings()) {
    const auto shaping = LightShaping::make(d);
    for (int i = 0; i < 20000; ++i) {
      const Vec3d a = unit(), b = unit();
      const double sine = i % 3 == 0 ? 1 : length(cross(a, b));
      if (sine < 1 && dot(a, b) < 0) continue;
      EXPECT_LE(static_cast<double>(luminance(shaping->factor(b))), shaping->largest(a, sine) * (1 + 1e-6));
    }
    if (luminance(d.focus_tint) < 1) {
      EXPECT_NEAR(shaping->largest(at_degrees(25), 0), static_cast<double>(luminance(factor(d, 25))), 1e-4);
    }
  }
}

// Each light that has a place is shaped about its own -z, whatever its transform mirrors.
TEST(LightShaping, EveryLightThatHasAPlaceIsShaped) {
  for (const LightType type : {LightType::rect, LightType::disk, LightType::sphere, LightType::cylinder}) {
    LightParameters d;
    d.type = type;
    d.radius = d.width = d.height = d.length = 0.01f;
    d.cone_angle = 40;
    d.focus = 2;
    d.light_to_world = Matrix4d(0, 0, 2, 0, 0, 2, 0, 0, 2, 0, 0, 0, 0, 0, 0, 1);  // mirrored; local -z is world -x
    const Light light = make_light(d, Vec3d(0, 0, 0));
    const auto radiance = [&](double degrees) {
      const double a = degrees * kPiDouble / 180;
      const Vec3f p(Vec3d(-std::cos(a), std::sin(a), 0) * 3);
      Rng rng(2, 1);
      for (int i = 0; i < 20; ++i) {  // some directions pass a disk or a cylinder by
        const float x = rng.uniform();
        const auto s = std::visit([&](const auto& l) { return l.sample(p, {x, rng.uniform()}); }, light);
        if (s) return s->radiance.g;
      }
      EXPECT_EQ(std::visit([&](const auto& l) { return l.importance(p); }, light), 0);
      return 0.0f;
    };
    EXPECT_NEAR(radiance(30), 0.75f, 0.02f);
    EXPECT_EQ(radiance(50), 0);
  }
}

}  // namespace
}  // namespace alabaster
