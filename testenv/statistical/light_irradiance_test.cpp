// The irradiance of lights on a plane, compared with closed forms.
#include <gtest/gtest.h>

#include <array>

#include "core/light/light_set.h"
#include "core/sampling/mis.h"
#include "core/sampling/warp.h"
#include "testenv/support/chi_square.h"
#include "testenv/support/emitted_light.h"
#include "testenv/support/memory_texture.h"
#include "testenv/support/z_test.h"

namespace alabaster::testing {
namespace {

struct Plane {
  Vec3f p, n;
};

template <class L>
RunningStatistics irradiance(const L& light, const Plane& plane, int samples, uint64_t seed) {
  Rng rng(run_seed(seed), 1);
  RunningStatistics e;
  for (int i = 0; i < run_samples(samples); ++i) {
    const auto s = light.sample(plane.p, uniform2(rng));
    e.add(s ? static_cast<double>(s->radiance.r * std::max(0.0f, dot(s->wi, plane.n)) / s->pdf) : 0.0);
  }
  return e;
}

void expect(const RunningStatistics& e, double expected, const char* name) {
  const auto r = z_test(e, expected, {.slack = 2e-6 * expected});
  EXPECT_TRUE(plausible(r)) << name;
}

// Lambert 1760: E = L/2 sum of (angle of edge i) * (n . unit normal of the plane through edge i and p), for a polygon
// wholly above the plane.
double lambert_polygon(const Plane& plane, const std::array<Vec3d, 4>& corners) {
  const Vec3d p(plane.p);
  double sum = 0;
  for (size_t i = 0; i < 4; ++i) {
    const Vec3d a = normalize(corners[i] - p), b = normalize(corners[(i + 1) % 4] - p), c = cross(a, b);
    sum += std::atan2(length(c), dot(a, b)) * dot(Vec3d(plane.n), c) / length(c);
  }
  return 0.5 * std::abs(sum);
}

Matrix4d translation(double x, double y, double z) {
  return Matrix4d(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, x, y, z, 1);
}

TEST(LightIrradiance, RectIsLambertsFormula) {
  LightParameters d;
  d.width = 2;
  d.height = 0.5f;
  d.color = Rgb(3, 1, 1);
  d.light_to_world = translation(10.25, 0, 3);  // faces down
  const Vec3d origin(10, 0, 0);
  const RectDiskLight light(d, origin);
  const std::array<Vec3d, 4> corners = {Vec3d(-0.75, -0.25, 3), Vec3d(1.25, -0.25, 3), Vec3d(1.25, 0.25, 3),
                                        Vec3d(-0.75, 0.25, 3)};
  uint64_t seed = 100;
  for (const Plane& plane : {Plane{{0, 0, 0}, {0, 0, 1}}, Plane{{0, 0, 2.9f}, {0, 0, 1}},
                             Plane{{3, 2, 0}, normalize(Vec3f(-1, 0, 1))}, Plane{{0.25f, 0, 2.999f}, {0, 0, 1}},
                             Plane{{-300, 0, 0}, normalize(Vec3f(1, 0, 1))}, Plane{{5, 0, 2.97f}, {-1, 0, 0}}})
    expect(irradiance(light, plane, 40000, seed++), 3 * lambert_polygon(plane, corners), "rect");
}

// A disk of radius r at height h seen from the plane below it, a from its axis: pi L / 2 (1 - (h^2 + a^2 - r^2) /
// sqrt((h^2 + a^2 + r^2)^2 - 4 a^2 r^2)), on the axis pi L sin^2.
TEST(LightIrradiance, DiskOverAParallelPlane) {
  LightParameters d;
  d.type = LightType::disk;
  d.radius = 0.75f;
  d.color = Rgb(3, 1, 1);
  d.light_to_world = translation(0, 0, 3);
  const RectDiskLight light(d, Vec3d(0, 0, 0));
  uint64_t seed = 120;
  for (const auto& [a, z] : {std::pair(0.0, 0.0), {0.0, 2.9}, {0.5, 2.75}, {1.5, 2.5}, {20.0, 0.0}}) {
    const double h = 3 - z, r = 0.75, sum = h * h + a * a;
    const double expected =
        1.5 * kPiDouble * (1 - (sum - r * r) / std::sqrt((sum + r * r) * (sum + r * r) - 4 * a * a * r * r));
    expect(irradiance(light, {Vec3f(Vec3d(a, 0, z)), {0, 0, 1}}, 40000, seed++), expected, "disk");
  }
}

// Quadrature over the side of the tube that faces the plane and is above it.
TEST(LightIrradiance, Cylinder) {
  LightParameters d;
  d.type = LightType::cylinder;
  d.radius = 0.5f;
  d.length = 1.5f;
  d.normalize = true;
  d.light_to_world = Matrix4d(2, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0, 0, 0, 2, 1);  // mirrored, of length 3
  const CylinderLight light(d, Vec3d(0, 0, 0));
  uint64_t seed = 140;
  for (const Plane& plane : {Plane{{0, 0, 0}, {0, 0, 1}}, Plane{{0.3f, 0.2f, 1.45f}, {0, 0, 1}},
                             Plane{{4, 1, 1.75f}, normalize(Vec3f(-1, 0, 0.2f))}, Plane{{0.5f, 0.6f, 2}, {0, 0, 1}}}) {
    const Vec3d p(plane.p), n(plane.n);
    constexpr int kSteps = 1500;
    double expected = 0;
    for (int i = 0; i < kSteps; ++i)
      for (int j = 0; j < kSteps; ++j) {
        const double x = 3 * ((i + 0.5) / kSteps - 0.5), angle = 2 * kPiDouble * (j + 0.5) / kSteps;
        const Vec3d out(0, std::cos(angle), std::sin(angle)), to_light = Vec3d(x, 0, 2) + out * 0.5 - p;
        const double d2 = dot(to_light, to_light), facing = -dot(to_light, out), above = dot(to_light, n);
        if (facing > 0 && above > 0) expected += facing * above / (d2 * d2);
      }
    expected /= static_cast<double>(kSteps) * kSteps;  // radiance 1 / area
    const auto r = z_test(irradiance(light, plane, 40000, seed++), expected, {.slack = 1e-4 * expected});
    EXPECT_TRUE(plausible(r));
  }
}

// Quadrature over an image that grows with x and is brightest in one corner.
TEST(LightIrradiance, RectWithAnImage) {
  LightParameters d;
  d.width = 2;
  d.normalize = true;
  std::vector<Rgb> texels;
  for (int i = 0; i < 32; ++i) texels.emplace_back(i == 0 ? 50.0f : static_cast<float>(i % 8));
  d.texture = std::make_shared<MemoryTexture>(8, texels);
  d.light_to_world = translation(0, 0, 2);
  const RectDiskLight light(d, Vec3d(0, 0, 0));
  uint64_t seed = 160;
  for (const Plane& plane :
       {Plane{{0, 0, 0}, {0, 0, 1}}, Plane{{0.8f, 0.2f, 1.5f}, {0, 0, 1}}, Plane{{-4, 1, -3}, {0, 0, 1}}}) {
    constexpr int kSteps = 800;
    double expected = 0;
    for (int i = 0; i < kSteps; ++i)
      for (int j = 0; j < kSteps; ++j) {
        const double u = (i + 0.5) / kSteps, v = (j + 0.5) / kSteps;
        const double x = std::clamp(8 * u - 0.5, 0.0, 7.0), y = std::clamp(4 * v - 0.5, 0.0, 3.0);
        const auto texel = [&](int a, int b) { return static_cast<double>(texels[static_cast<size_t>(8 * b + a)].r); };
        const int a = std::min(static_cast<int>(x), 6), b = std::min(static_cast<int>(y), 2);
        const double low = std::lerp(texel(a, b), texel(a + 1, b), x - a),
                     high = std::lerp(texel(a, b + 1), texel(a + 1, b + 1), x - a);
        const Vec3d to_light = Vec3d(1 - 2 * u, 0.5 - v, 2) - Vec3d(plane.p);
        const double d2 = dot(to_light, to_light);
        expected += std::lerp(low, high, y - b) / 2 * to_light.z * to_light.z / (d2 * d2);
      }
    expected *= 2.0 / (kSteps * kSteps);
    const auto r = z_test(irradiance(light, plane, 40000, seed++), expected, {.slack = 1e-4 * expected});
    EXPECT_TRUE(plausible(r));
  }
}

// Cosine-weighted solid angle of a sphere fully above the plane: pi L (r/d)^2 cos.
TEST(LightIrradiance, SphereFullyAboveTheHorizon) {
  LightParameters d;
  d.type = LightType::sphere;
  d.intensity = 2;
  d.exposure = 1;
  d.light_to_world = translation(0, 0, 5);
  uint64_t seed = 200;
  for (float radius : {2.0f, 0.5f, 1e-3f, 1e-6f}) {
    d.radius = radius;
    const SphereLight light(d, Vec3d(0, 0, 0));
    for (const Plane& plane : {Plane{{0, 0, 0}, {0, 0, 1}}, Plane{{1, 2, 0}, {0, 0, 1}}}) {
      const Vec3d to_light = Vec3d(0, 0, 5) - Vec3d(plane.p);
      const double d2 = dot(to_light, to_light), r = static_cast<double>(radius);
      expect(irradiance(light, plane, 40000, seed++), 4 * kPiDouble * r * r / d2 * (5 / std::sqrt(d2)), "sphere");
    }
  }
}

TEST(LightIrradiance, InsideASphereIsPiL) {
  LightParameters d;
  d.type = LightType::sphere;
  d.radius = 1;
  expect(irradiance(SphereLight(d, Vec3d(0, 0, 0)), {{0.3f, 0.2f, -0.5f}, {0, 0, 1}}, 40000, 300), kPiDouble, "inside");
}

TEST(LightIrradiance, ConstantDomeIsPiL) {
  LightParameters d;
  d.type = LightType::dome;
  d.intensity = 0.5f;
  const Plane plane{{1, 2, 3}, normalize(Vec3f(1, -2, 3))};
  expect(irradiance(DomeLight(d, Vec3d(0, 0, 0)), plane, 40000, 400), 0.5 * kPiDouble, "constant");
  d.texture = std::make_shared<MemoryTexture>(16, std::vector<Rgb>(128, Rgb(0.5f)));
  expect(irradiance(DomeLight(d, Vec3d(0, 0, 0)), plane, 40000, 401), 0.25 * kPiDouble, "constant image");
}

// An image whose radiance is linear in longitude alone, on a plane facing the pole. Bilinear lookup reproduces the mean
// of the texels in every row, and the cosine to the pole does not depend on longitude, so E = pi * mean.
TEST(LightIrradiance, DomeImage) {
  LightParameters d;
  d.type = LightType::dome;
  std::vector<Rgb> texels;
  for (int y = 0; y < 8; ++y)
    for (int x = 0; x < 16; ++x) texels.emplace_back(static_cast<float>(x == 3 ? 100 : x));
  double mean = 0;
  for (int x = 0; x < 16; ++x) mean += (x == 3 ? 100 : x) / 16.0;
  d.texture = std::make_shared<MemoryTexture>(16, texels);
  const DomeLight light(d, Vec3d(0, 0, 0));
  expect(irradiance(light, {{0, 0, 0}, {0, 1, 0}}, 100000, 410), mean * kPiDouble, "up");
  expect(irradiance(light, {{0, 0, 0}, {0, -1, 0}}, 100000, 411), mean * kPiDouble, "down");
}

// A cone of half angle a around the normal gives pi L sin^2(a), which is color*intensity for a normalized light.
TEST(LightIrradiance, Distant) {
  LightParameters d;
  d.type = LightType::distant;
  d.intensity = 3;
  const Plane facing{{0, 0, 0}, {0, 0, 1}}, tilted{{0, 0, 0}, normalize(Vec3f(0, 1, 2))};
  uint64_t seed = 500;
  for (float angle : {0.0f, 1e-6f, 0.01f, 0.53f, 30.0f, 120.0f}) {
    d.angle = angle;
    const double half = static_cast<double>(angle) * kPiDouble / 360, s2 = std::sin(half) * std::sin(half);
    d.normalize = false;
    const double unnormalized = angle == 0 ? 3 : 3 * kPiDouble * s2;
    expect(irradiance(DistantLight(d, Vec3d(0, 0, 0)), facing, 40000, seed++), unnormalized, "facing");
    d.normalize = true;
    const DistantLight normalized(d, Vec3d(0, 0, 0));
    expect(irradiance(normalized, facing, 40000, seed++), 3, "normalized");
    if (angle < 35) {  // the cone stays above the tilted plane's horizon: E scales with the cosine of its axis
      expect(irradiance(normalized, tilted, 40000, seed++), 3 * 2 / std::sqrt(5.0), "tilted");
    }
  }
}

// A mesh of the rect's two triangles gives the same irradiance as the rect.
TEST(LightIrradiance, MeshIsLambertsFormula) {
  const std::array<Vec3d, 4> corners = {Vec3d(-1, -1, 2), Vec3d(1, -1, 2), Vec3d(1, 1, 2), Vec3d(-1, 1, 2)};
  const auto at = [&](size_t i) { return Vec3f(corners[i]); };
  const MeshLight light(0, {{at(0), at(1), at(2), Rgb(1, 3, 2)}, {at(0), at(2), at(3), Rgb(1, 0, 2)}}, {0, 1});
  const Plane plane{{0.5f, 0.25f, 0}, normalize(Vec3f(0.2f, 0.1f, 1))};
  expect(irradiance(light, plane, 100000, 600), lambert_polygon(plane, corners), "mesh");
}

// Makes one light of a light set. The choice takes random numbers of its own.
struct Choosing {
  const LightSet& set;
  mutable Rng rng;
  Choosing(const LightSet& lights, uint64_t seed) : set(lights), rng(seed, 2) {}
  std::optional<LightSample> sample(const Vec3f& p, const Vec2f& u) const { return set.sample(p, rng.uniform(), u); }
};

// One sample of the chosen light and of each constant dome, at a plane that faces z, times `weigh` of the sample.
template <class Weigh>
double sampled_irradiance(const LightSet& set, const Plane& plane, Rng& rng, const Weigh& weigh) {
  const float choice = rng.uniform();
  const Vec2f u = uniform2(rng);
  double value = 0;
  for (size_t k = 0; k < set.draws(ConstantDomes::sampled); ++k) {
    const auto s = set.draw(k, plane.p, {plane.n, plane.n}, {choice, u.x, u.y, 0}, ConstantDomes::sampled);
    if (s && s->wi.z > 0) value += static_cast<double>(s->radiance.r * s->wi.z / s->pdf * weigh(*s));
  }
  return value;
}

// The lights and one sample of the cosine, weighted by the power heuristic.
double weighed_irradiance(const LightSet& set, const Plane& plane, Rng& rng) {
  double value = sampled_irradiance(
      set, plane, rng, [](const LightSample& s) { return s.delta ? 1.0f : power_heuristic(s.pdf, s.wi.z * kInvPi); });
  const Vec3f w = sample_cosine_hemisphere(uniform2(rng));
  const float pdf = pdf_cosine_hemisphere(w);
  const auto weigh = [&](float light_pdf) { return power_heuristic(pdf, light_pdf); };
  if (pdf > 0)
    value += static_cast<double>(emitted_light(set, {plane.p, w}, true, false, ConstantDomes::sampled, weigh).r * kPi);
  return value;
}

// Sampling lights and sampling directions, weighted by the power heuristic, give the sum of the closed forms only if
// the pdfs of both, including the choice of the light, agree.
TEST(LightIrradiance, LightSetWithMultipleImportanceSampling) {
  LightParameters rect;
  rect.light_to_world = translation(0, 0, 2);
  rect.width = rect.height = 3;
  LightParameters sphere;
  sphere.type = LightType::sphere;
  sphere.radius = 1;
  sphere.intensity = 5;
  sphere.light_to_world = translation(3, 0, 2);
  LightParameters dome;
  dome.type = LightType::dome;
  dome.intensity = 0.2f;
  LightParameters sun;
  sun.type = LightType::distant;
  sun.angle = 20;
  LightParameters black = sphere;
  black.intensity = 0;
  const Vec3d o(0, 0, 0);
  const LightSet set(
      {RectDiskLight(rect, o), SphereLight(black, o), SphereLight(sphere, o), DomeLight(dome, o), DistantLight(sun, o)},
      {});
  const Plane plane{{0, 0, 0}, {0, 0, 1}};
  const std::array<Vec3d, 4> corners = {Vec3d(-1.5, -1.5, 2), Vec3d(1.5, -1.5, 2), Vec3d(1.5, 1.5, 2),
                                        Vec3d(-1.5, 1.5, 2)};
  const double sin_sun = std::sin(10 * kPiDouble / 180);
  const double expected = lambert_polygon(plane, corners) + 5 * kPiDouble / 13 * 2 / std::sqrt(13.0) + 0.2 * kPiDouble +
                          kPiDouble * sin_sun * sin_sun;
  Rng rng(run_seed(700), 1);
  RunningStatistics e;
  for (int i = 0; i < run_samples(200000); ++i) e.add(weighed_irradiance(set, plane, rng));
  expect(e, expected, "light set");
}

// A small bright rect, a point and a dim dome give the sum of the closed forms at each point, even where one light
// outshines the others or the rect faces away.
TEST(LightIrradiance, LightSetOfVeryDifferentLights) {
  LightParameters rect;
  rect.light_to_world = translation(0, 0, 1);
  rect.width = rect.height = 0.2f;
  rect.intensity = 1000;
  LightParameters point;
  point.type = LightType::sphere;
  point.treat_as_point = true;
  point.intensity = 0.5f;
  point.light_to_world = translation(20, 0, 1.5);
  LightParameters dome;
  dome.type = LightType::dome;
  dome.intensity = 0.01f;
  const Vec3d o(0, 0, 0);
  const LightSet set({RectDiskLight(rect, o), SphereLight(point, o), DomeLight(dome, o)}, {});
  const std::array<Vec3d, 4> corners = {Vec3d(-0.1, -0.1, 1), Vec3d(0.1, -0.1, 1), Vec3d(0.1, 0.1, 1),
                                        Vec3d(-0.1, 0.1, 1)};
  uint64_t seed = 710;
  for (const Plane& plane : {Plane{{0, 0, 0}, {0, 0, 1}}, Plane{{20, 0.1f, 1.25f}, {0, 0, 1}},
                             Plane{{1000, 2000, 0}, {0, 0, 1}}, Plane{{0, 0, 0.99f}, {0, 0, 1}}}) {
    const Vec3d to_point = Vec3d(20, 0, 1.5) - Vec3d(plane.p);
    const double d = length(to_point);
    const double from_rect = plane.p.z < 1 ? 1000 * lambert_polygon(plane, corners) : 0;
    const double expected = from_rect + 0.5 * to_point.z / (d * d * d) + 0.01 * kPiDouble;
    Rng rng(run_seed(seed), 1);
    RunningStatistics chosen, weighed;
    for (int i = 0; i < run_samples(100000); ++i)
      chosen.add(sampled_irradiance(set, plane, rng, [](const LightSample&) { return 1.0f; }));
    expect(chosen, expected, "chosen lights");
    rng = Rng(run_seed(++seed), 1);
    for (int i = 0; i < run_samples(100000); ++i) weighed.add(weighed_irradiance(set, plane, rng));
    expect(weighed, expected, "weighed");
    ++seed;
  }
}

// This is why the choice depends on the point: a key light of 0.3 beside a sky over a ground of 20. By power nearly all
// samples go to the sky, which illuminates a sphere around all of the ground, but nearly all light comes from the key.
TEST(LightIrradiance, ChoosingLightsAtThePointReducesNoise) {
  LightParameters key;
  key.light_to_world = translation(0, 0, 0.8);
  key.width = key.height = 0.3f;
  key.intensity = 34;
  LightParameters sky;
  sky.type = LightType::dome;
  sky.intensity = 0.06f;
  const RectDiskLight rect(key, Vec3d(0, 0, 0));
  const DomeLight dome(sky, Vec3d(0, 0, 0));
  const LightSet set({rect, dome}, {});
  const double key_power = 34 * kPiDouble * 0.09, sky_power = 4 * kPiDouble * 0.06 * kPiDouble * 200;
  const auto key_share = static_cast<float>(0.75 * key_power / (key_power + sky_power) + 0.125);
  const Plane plane{{0.1f, 0.1f, 0}, {0, 0, 1}};
  Rng rng(run_seed(730), 1);
  RunningStatistics by_power;
  for (int i = 0; i < run_samples(100000); ++i) {
    const bool at_key = rng.uniform() < key_share;
    const Vec2f u = uniform2(rng);
    const auto s = at_key ? rect.sample(plane.p, u) : dome.sample(plane.p, u);
    const float pdf = s ? s->pdf * (at_key ? key_share : 1 - key_share) : 1;
    by_power.add(s ? static_cast<double>(s->radiance.r * std::max(0.0f, s->wi.z) / pdf) : 0.0);
  }
  const auto at_point = irradiance(Choosing{set, 731}, plane, 100000, 731);
  const double gain = by_power.variance() / at_point.variance();
  RecordProperty("gain", std::to_string(gain));
  EXPECT_GT(gain, 20);
}

// Small disks over a floor: the tree gives their sum, and with less noise than a light chosen by lot.
TEST(LightIrradiance, LightTreeReducesNoise) {
  Rng place(run_seed(740), 1);
  std::vector<RectDiskLight> disks;
  std::vector<Light> lights;
  std::vector<Vec3d> centers;
  constexpr size_t kLights = 1000;
  for (size_t i = 0; i < kLights; ++i) {
    LightParameters d;
    d.type = LightType::disk;
    d.radius = 0.01f;
    const double x = 20 * place.uniform() - 10, y = 20 * place.uniform() - 10, z = 1 + 2 * place.uniform();
    d.light_to_world = translation(x, y, z);
    centers.emplace_back(x, y, z);
    disks.emplace_back(d, Vec3d(0, 0, 0));
    lights.emplace_back(disks.back());
  }
  const LightSet set(lights, {});
  uint64_t seed = 741;
  for (const Vec3f& p : {Vec3f(0, 0, 0), Vec3f(7, -3, 0.5f), Vec3f(-30, 0, 0)}) {
    double expected = 0;
    for (const Vec3d& c : centers) {
      const Vec3d d = c - Vec3d(p);
      expected += kPiDouble * 1e-4 * d.z * d.z / (dot(d, d) * dot(d, d));
    }
    const auto tree = irradiance(Choosing{set, seed}, {p, {0, 0, 1}}, 100000, seed);
    const auto r = z_test(tree, expected, {.slack = 1e-3 * expected});
    EXPECT_TRUE(plausible(r));
    Rng rng(run_seed(seed++), 3);
    RunningStatistics by_lot;
    for (int i = 0; i < run_samples(100000); ++i) {
      const auto s = disks[static_cast<size_t>(rng.uniform() * kLights)].sample(p, uniform2(rng));
      by_lot.add(s ? static_cast<double>(s->radiance.r * s->wi.z / s->pdf * kLights) : 0.0);
    }
    const double gain = by_lot.variance() / tree.variance();
    RecordProperty("gain_" + std::to_string(seed), std::to_string(gain));
    EXPECT_GT(gain, 3) << p;
  }
}

// This is why the rect light samples solid angles from near: compares the variance of irradiance with sampling points
// of its area.
TEST(LightIrradiance, SolidAngleSamplingOfTheRectReducesNoise) {
  LightParameters d;
  d.light_to_world = translation(0, 0, 1);
  const RectDiskLight light(d, Vec3d(0, 0, 0));
  struct Case {
    Plane plane;
    double least_gain;
  };
  for (const auto& [plane, least_gain] :
       {Case{{{0, 0, 0.9f}, {0, 0, 1}}, 40.0}, Case{{{0, 0, 0.5f}, {0, 0, 1}}, 12.0},
        Case{{{0, 0, 0}, {0, 0, 1}}, 12.0}, Case{{{1, 0, 0.8f}, normalize(Vec3f(-1, 0, 1))}, 150.0}}) {
    Rng rng(run_seed(800), 1);
    RunningStatistics by_area;
    for (int i = 0; i < run_samples(40000); ++i) {
      const Vec2f u = uniform2(rng);
      const Vec3f to_light = Vec3f(u.x - 0.5f, u.y - 0.5f, 1) - plane.p, wi = normalize(to_light);
      by_area.add(static_cast<double>(std::max(0.0f, dot(wi, plane.n)) * wi.z / dot(to_light, to_light)));
    }
    const auto by_solid_angle = irradiance(light, plane, 40000, 801);
    const double gain = by_area.variance() / by_solid_angle.variance();
    RecordProperty("gain_" + std::to_string(plane.p.z), std::to_string(gain));
    EXPECT_GT(gain, least_gain) << "at z = " << plane.p.z;
  }
}

// The family would detect a radiance or pdf that is off by one per cent.
TEST(LightIrradiance, WrongExpectationFails) {
  const Plane plane{{0, 0, 0}, {0, 0, 1}};
  LightParameters d;
  d.light_to_world = translation(0, 0, 3);
  const std::array<Vec3d, 4> corners = {Vec3d(-0.5, -0.5, 3), Vec3d(0.5, -0.5, 3), Vec3d(0.5, 0.5, 3),
                                        Vec3d(-0.5, 0.5, 3)};
  const auto e = irradiance(RectDiskLight(d, Vec3d(0, 0, 0)), plane, 40000, 900);
  EXPECT_TRUE(noticed(z_test(e, 1.01 * lambert_polygon(plane, corners))));
}

}  // namespace
}  // namespace alabaster::testing
