// The contract of all lights: samples and hits agree, bad input gives no bad values, and units do not matter.
#include "core/light/light.h"

#include <gtest/gtest.h>

#include <limits>

#include "core/sampling/pixel_sampler.h"
#include "testenv/support/memory_texture.h"

namespace alabaster {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

std::vector<LightParameters> some_of_each() {
  LightParameters rect;
  rect.width = 3;
  rect.light_to_world = Matrix4d(1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 1, 2, 3, 1);
  LightParameters sheared = rect;
  sheared.light_to_world[0][2] = 0.7;
  LightParameters sphere;
  sphere.type = LightType::sphere;
  sphere.light_to_world[3][1] = 4;
  LightParameters spot = sphere;
  spot.cone_inner = 20;
  spot.cone_outer = 60;
  LightParameters point = spot;
  point.treat_as_point = true;
  LightParameters sun;
  sun.type = LightType::distant;
  LightParameters ray = sun;
  ray.angle = 0;
  LightParameters sky;
  sky.type = LightType::dome;
  LightParameters image = sky;
  std::vector<Rgb> texels(8, Rgb(0.5f, 1, 2));
  texels[5] = Rgb(0.0f);
  texels[3] = Rgb(90, 80, 70);
  image.texture = std::make_shared<testing::MemoryTexture>(4, texels);
  LightParameters disk = sheared;
  disk.type = LightType::disk;
  LightParameters round = disk;
  round.light_to_world = Matrix4d();
  round.radius = 2;
  LightParameters tube;
  tube.type = LightType::cylinder;
  tube.light_to_world = Matrix4d(0, 2, 0, 0, 0.5, 0, 0.1, 0, 0, 0.2, -1, 0, 0.5, 0.25, 0, 1);  // uneven and mirrored
  LightParameters shaped = tube;
  shaped.cone_angle = 100;
  shaped.cone_softness = 0.5f;
  shaped.focus = 2;
  LightParameters screen = rect;
  screen.texture = image.texture;
  return {rect, sheared, sphere, spot, point, sun, ray, sky, image, disk, round, tube, shaped, screen};
}

std::optional<LightSample> sample(const Light& light, const Vec3f& p, const Vec2f& u) {
  return std::visit([&](const auto& l) { return l.sample(p, u); }, light);
}
std::optional<LightHit> intersect(const Light& light, const Ray& ray) {
  return std::visit(
      [&](const auto& l) -> std::optional<LightHit> {
        if constexpr (requires { l.intersect(ray); }) return l.intersect(ray);
        return std::nullopt;
      },
      light);
}
double importance(const Light& light, const Vec3f& p) {
  return std::visit([&](const auto& l) { return l.importance(p); }, light);
}

void expect_sane(const LightSample& s) {
  EXPECT_TRUE(std::isfinite(s.pdf) && s.pdf > 0);
  EXPECT_NEAR(length(s.wi), 1, 1e-6f);
  EXPECT_TRUE(s.distance > 0);
  EXPECT_TRUE(is_finite(s.radiance) && !is_black(s.radiance));
  EXPECT_TRUE(s.radiance.r >= 0 && s.radiance.g >= 0 && s.radiance.b >= 0);
}

TEST(Lights, HitsAgreeWithSamples) {
  Rng rng(1, 1);
  size_t kind = 0;
  for (const LightParameters& d : some_of_each()) {
    const Light light = make_light(d, Vec3d(0, 0, 0));
    int sampled = 0, met = 0, equal = 0;
    for (int i = 0; i < 5000; ++i) {
      const Vec3f p(6 * rng.uniform() - 3, 6 * rng.uniform() - 3, 6 * rng.uniform() - 3);
      const float x = rng.uniform();
      const auto s = sample(light, p, {x, rng.uniform()});
      if (!s) continue;
      ++sampled;
      expect_sane(*s);
      const auto hit = intersect(light, {p, s->wi * 2.0f});
      EXPECT_FALSE(hit && s->delta);
      if (!hit) continue;
      ++met;
      EXPECT_EQ(std::isinf(s->distance), std::isinf(hit->t));
      if (!std::isinf(s->distance)) {
        EXPECT_NEAR(2 * hit->t / s->distance, 1, 1e-3f);
      }
      const bool same = std::abs(hit->pdf / s->pdf - 1) < 1e-4f && std::abs(hit->radiance.g - s->radiance.g) < 2e-2f;
      equal += same ? 1 : 0;
    }
    EXPECT_GT(sampled, 500) << kind;
    // Directions are rounded to float: a few on the outline (or on the edge of a dome's texel) end up beyond it.
    if (met > 0 || kind < 4) {
      EXPECT_GT(met, 0.995 * sampled) << kind;
      EXPECT_GT(equal, 0.995 * met) << kind;
    }
    ++kind;
  }
}

// Lengths times 2^k: the same directions, radiances and pdfs to the last bit, distances times 2^k.
TEST(Lights, DoNotDependOnTheUnitOfLength) {
  for (const LightParameters& d : some_of_each()) {
    for (int k : {-40, -10, 13, 40}) {
      const float scale = std::ldexp(1.0f, k);
      LightParameters scaled = d;
      for (int row = 0; row < 4; ++row)
        for (int column = 0; column < 3; ++column) scaled.light_to_world[row][column] *= std::ldexp(1.0, k);
      // Radiant intensity per distance squared is the one quantity with a length in it.
      if (d.treat_as_point) scaled.exposure = static_cast<float>(2 * k);
      const Light a = make_light(d, Vec3d(1, 2, 3)), b = make_light(scaled, Vec3d(1, 2, 3) * std::ldexp(1.0, k));
      Rng rng(2, 1);
      for (int i = 0; i < 200; ++i) {
        const Vec3f p(6 * rng.uniform() - 3, 6 * rng.uniform() - 3, 6 * rng.uniform() - 3);
        const float x = rng.uniform();
        const Vec2f u(x, rng.uniform());
        EXPECT_EQ(importance(a, p), importance(b, p * scale));
        const auto s = sample(a, p, u), t = sample(b, p * scale, u);
        ASSERT_EQ(s.has_value(), t.has_value());
        if (!s) continue;
        EXPECT_EQ(s->wi, t->wi);
        EXPECT_EQ(s->pdf, t->pdf);
        EXPECT_EQ(s->radiance, t->radiance);
        EXPECT_EQ(s->distance * scale, t->distance);
        const auto hit = intersect(a, {p, s->wi}), scaled_hit = intersect(b, {p * scale, s->wi});
        ASSERT_EQ(hit.has_value(), scaled_hit.has_value());
        if (!hit) continue;
        EXPECT_EQ(hit->pdf, scaled_hit->pdf);
        EXPECT_EQ(hit->t * scale, scaled_hit->t);
      }
    }
  }
}

// A light that may give light somewhere must be choosable there, or the picture lacks it.
TEST(Lights, ImportanceIsPositiveWhereverThereIsLight) {
  Rng rng(4, 1);
  size_t kind = 0;
  for (LightParameters d : some_of_each()) {
    d.color = Rgb(0, 0, 1e-30f);
    const Light light = make_light(d, Vec3d(0, 0, 0));
    int lit = 0;
    for (int i = 0; i < 20000; ++i) {
      const float reach = i % 2 == 0 ? 6.0f : 1e6f;
      const Vec3f p(reach * (rng.uniform() - 0.5f), reach * (rng.uniform() - 0.5f), reach * (rng.uniform() - 0.5f));
      const float x = rng.uniform();
      const auto s = sample(light, p, {x, rng.uniform()});
      const double w = importance(light, p);
      EXPECT_TRUE(std::isfinite(w) && w >= 0);
      if (s) {
        EXPECT_GT(w, 0) << kind << " at " << p;
        ++lit;
      }
    }
    EXPECT_GT(lit, 500) << kind;
    ++kind;
  }
}

// Only differences to the render origin count: a scene far from the world's origin is lit as one near it.
TEST(Lights, AreFreeOfTheRenderOrigin) {
  for (LightParameters d : some_of_each()) {
    const Light near_origin = make_light(d, Vec3d(0, 0, 0));
    const Vec3d away(1 << 24, -(1 << 25), 1 << 24);
    for (int i = 0; i < 3; ++i) d.light_to_world[3][i] += away[i];
    const Light far_away = make_light(d, away);
    const auto s = sample(near_origin, {0.5f, 0.5f, 1}, {0.3f, 0.6f}),
               t = sample(far_away, {0.5f, 0.5f, 1}, {0.3f, 0.6f});
    ASSERT_EQ(s.has_value(), t.has_value());
    if (!s) continue;
    EXPECT_EQ(s->wi, t->wi);
    EXPECT_EQ(s->pdf, t->pdf);
  }
}

void expect_dark(const LightParameters& d, const char* why) {
  const Light light = make_light(d, Vec3d(0, 0, 0));
  Rng rng(3, 1);
  for (int i = 0; i < 50; ++i) {
    const Vec3f p(rng.uniform() - 0.5f, rng.uniform() - 0.5f, rng.uniform() - 5.5f);
    const float x = rng.uniform();
    EXPECT_EQ(importance(light, p), 0) << why;
    EXPECT_FALSE(sample(light, p, {x, rng.uniform()})) << why;
    EXPECT_FALSE(intersect(light, {p, {0, 0, 1}})) << why;
  }
}

TEST(Lights, BadDescriptionsGiveNoLight) {
  for (const LightParameters& d : some_of_each()) {
    LightParameters bad = d;
    bad.intensity = 0;
    expect_dark(bad, "zero intensity");
    bad.intensity = -1;
    expect_dark(bad, "negative intensity");
    bad.intensity = kNaN;
    expect_dark(bad, "NaN intensity");
    bad = d;
    bad.color.g = kInf;
    expect_dark(bad, "infinite colour");
    bad = d;
    bad.exposure = 1e6f;
    expect_dark(bad, "exposure beyond floats");
    bad = d;
    bad.light_to_world[1][1] = std::numeric_limits<double>::quiet_NaN();
    expect_dark(bad, "NaN in the transform");
    bad = d;
    for (int row = 0; row < 3; ++row) bad.light_to_world[row][0] = 0;
    expect_dark(bad, "singular transform");
    bad = d;
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 3; ++column) bad.light_to_world[row][column] *= 1e200;
    if (d.type != LightType::dome && d.type != LightType::distant && !d.treat_as_point) {
      expect_dark(bad, "size beyond floats");
    }
  }
  LightParameters d;
  d.width = 0;
  expect_dark(d, "no width");
  d.width = kNaN;
  expect_dark(d, "NaN width");
  for (const LightType type : {LightType::sphere, LightType::disk, LightType::cylinder}) {
    d = {};
    d.type = type;
    d.radius = kNaN;
    expect_dark(d, "NaN radius");
    d.radius = 0;
    if (type != LightType::sphere) expect_dark(d, "no radius");
  }
  d.radius = 1;
  d.length = 0;
  expect_dark(d, "no length");
  d = {};
  d.type = LightType::sphere;
  d.cone_inner = d.cone_outer = 0;
  expect_dark(d, "cone without width");
  d = {};
  d.type = LightType::distant;
  d.angle = kNaN;
  expect_dark(d, "NaN angle");
  d = {};
  d.type = LightType::dome;
  d.texture = std::make_shared<testing::MemoryTexture>(2, std::vector<Rgb>(2, Rgb(0.0f)));
  expect_dark(d, "black image");
  d.type = LightType::rect;
  expect_dark(d, "black image");
}

TEST(Lights, BadPointsAndRaysGiveNothingBad) {
  for (const LightParameters& d : some_of_each()) {
    const Light light = make_light(d, Vec3d(0, 0, 0));
    for (const Vec3f& p : {Vec3f(kNaN, 0, 0), Vec3f(0, kInf, 0), Vec3f(3e38f, 3e38f, 3e38f), Vec3f(1, 2, 3),
                           Vec3f(0, 4, 0), Vec3f(0, 4.5f, 0), Vec3f(0, 0, 0)}) {
      EXPECT_TRUE(importance(light, p) >= 0 && std::isfinite(importance(light, p)));
      for (const Vec2f& u : {Vec2f(0, 0), Vec2f(0x1.fffffep-1f, 0x1.fffffep-1f), Vec2f(0.5f, 0.5f), Vec2f(0, 0.75f)})
        if (const auto s = sample(light, p, u)) expect_sane(*s);
      for (const Vec3f& w :
           {Vec3f(0, 0, 0), Vec3f(kNaN, 0, 1), Vec3f(0, 1, 0), Vec3f(0, -1e-30f, 0), Vec3f(1e30f, 0, 0)})
        if (const auto hit = intersect(light, {p, w})) {
          EXPECT_TRUE(hit->t > 0 && std::isfinite(hit->pdf) && hit->pdf > 0);
          EXPECT_TRUE(is_finite(hit->radiance));
        }
    }
  }
}

TEST(Lights, NegativeChannelsAreCutAlone) {
  LightParameters d;
  d.color = Rgb(-1, 2, 3);
  d.intensity = 2;
  d.exposure = 3;
  EXPECT_EQ(emission(d), Rgb(0, 32, 48));
}

}  // namespace
}  // namespace alabaster
