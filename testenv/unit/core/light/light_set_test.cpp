#include "core/light/light_set.h"

#include <gtest/gtest.h>

#include "core/sampling/pixel_sampler.h"
#include "core/sampling/warp.h"
#include "testenv/support/emitted_light.h"

namespace alabaster {
namespace {

const Vec3d kOrigin(0, 0, 0);

LightParameters described(LightType type, float intensity) {
  LightParameters d;
  d.type = type;
  d.intensity = intensity;
  return d;
}
Light sphere(float intensity) {
  return SphereLight(described(LightType::sphere, intensity), kOrigin);
}
Light dome(float intensity) {
  return DomeLight(described(LightType::dome, intensity), kOrigin);
}
/// A disk in the direction z.
Light sun(float degrees, float intensity) {
  LightParameters d = described(LightType::distant, intensity);
  d.angle = degrees;
  return DistantLight(d, kOrigin);
}
const auto kUnweighted = [](float) { return 1.0f; };

TEST(LightSet, EmptyAndDarkSetsGiveNothing) {
  EXPECT_FALSE(LightSet().sample({0, 0, 0}, 0.5f, {0.5f, 0.5f}));
  EXPECT_EQ(LightSet().mesh_light_pdf({}, 1, 0, 0), 0);
  const LightSet dark({sphere(0), dome(0)}, {});
  EXPECT_FALSE(dark.sample({0, 0, -3}, 0.5f, {0.5f, 0.5f}));
  EXPECT_TRUE(is_black(
      testing::emitted_light(dark, {{0, 0, -3}, {0, 0, 1}}, true, false, ConstantDomes::sampled, kUnweighted)));
  EXPECT_EQ(dark.choice_probability(0, {0, 0, -3}), 0);
}

// A far clipping plane shortens the camera's rays.
TEST(LightSet, AnEscapedRayOfAnyLengthMeetsTheSky) {
  const LightSet set({sphere(1), dome(2)}, {});
  const Ray ray{{0, 0, 3}, {0, 0, 1}, 10};
  EXPECT_EQ(testing::emitted_light(set, ray, true, true, ConstantDomes::sampled, kUnweighted).g, 2);
  EXPECT_TRUE(is_black(testing::emitted_light(set, ray, false, true, ConstantDomes::sampled, kUnweighted)));
}

TEST(LightSet, PdfHoldsTheChoice) {
  const SphereLight small(described(LightType::sphere, 1), kOrigin);
  const LightSet set({small, sun(20, 1)}, {});
  const Vec3f p(0, 0, -3);
  const auto s = set.sample(p, 0, {0.3f, 0.4f});
  ASSERT_TRUE(s);
  EXPECT_EQ(s->pdf, small.sample(p, {0.3f, 0.4f})->pdf * set.choice_probability(0, p));
  const auto far = set.sample(p, 0.999f, {0.3f, 0.4f});
  ASSERT_TRUE(far);
  EXPECT_NEAR(far->pdf, set.choice_probability(1, p) * pdf_uniform_cone(1 - std::cos(kPi / 18)), 1e-3f);
  // The radiance and pdf for a ray that meets both lights.
  std::vector<float> pdfs;
  testing::emitted_light(set, {p, {0, 0, 1}}, true, false, ConstantDomes::sampled, [&](float pdf) {
    pdfs.push_back(pdf);
    return 1.0f;
  });
  ASSERT_EQ(pdfs.size(), 2u);
  EXPECT_NEAR(pdfs[0] / s->pdf, 1, 1e-6f);
  EXPECT_EQ(pdfs[1], far->pdf);

  LightParameters point = described(LightType::sphere, 1);
  point.treat_as_point = true;
  const LightSet pair({SphereLight(point, kOrigin), SphereLight(point, kOrigin)}, {});
  EXPECT_EQ(pair.sample(p, 0.2f, {0, 0})->pdf, 0.5f) << "a delta light's choice counts too";
}

TEST(LightSet, EmittedHonoursDistanceEscapeAndCamera) {
  const LightSet set({sphere(1), dome(4)}, {{false, true}, {}});
  Ray ray{{0, 0, -3}, {0, 0, 1}};
  EXPECT_EQ(testing::emitted_light(set, ray, true, false, ConstantDomes::sampled, kUnweighted), Rgb(5.0f));
  EXPECT_EQ(testing::emitted_light(set, ray, true, true, ConstantDomes::sampled, kUnweighted), Rgb(4.0f))
      << "the sphere is hidden from cameras";
  ray.tmax = 10;
  EXPECT_EQ(testing::emitted_light(set, ray, false, false, ConstantDomes::sampled, kUnweighted), Rgb(1.0f))
      << "stopped behind the sphere";
  ray.tmax = 2;
  EXPECT_EQ(testing::emitted_light(set, ray, false, false, ConstantDomes::sampled, kUnweighted), Rgb(0.0f))
      << "stopped before it";
  EXPECT_EQ(testing::emitted_light(set, ray, false, false, ConstantDomes::sampled, [](float) { return 0.5f; }),
            Rgb(0.0f));
}

// Infinite lights are asked by escaped rays only, after the finite ones, wherever they stand in the list.
TEST(LightSet, OnlyEscapedRaysMeetInfiniteLights) {
  const LightSet set({dome(4), sun(20, 8), sphere(1)}, {});
  const Ray ray{{0, 0, -3}, {0, 0, 1}};
  std::vector<float> pdfs;
  const auto keep = [&](float pdf) { return pdfs.push_back(pdf), 1.0f; };
  EXPECT_EQ(testing::emitted_light(set, ray, false, false, ConstantDomes::sampled, keep), Rgb(1.0f));
  EXPECT_EQ(pdfs.size(), 1u);
  pdfs.clear();
  EXPECT_EQ(testing::emitted_light(set, ray, true, false, ConstantDomes::sampled, keep), Rgb(13.0f));
  ASSERT_EQ(pdfs.size(), 3u);
  EXPECT_EQ(pdfs[1], pdf_uniform_sphere()) << "a constant dome takes no part in the choice";
  EXPECT_NEAR(pdfs[2] / pdf_uniform_cone(1 - std::cos(kPi / 18)), set.choice_probability(1, ray.org), 1e-5f);
}

/// A dome of that radiance between `others` spheres of that intensity. All are sampled, one is chosen by its importance
/// or by a tree.
LightSet domed(float radiance, size_t others, float intensity) {
  std::vector<Light> lights(others, sphere(intensity));
  lights.insert(lights.begin() + static_cast<std::ptrdiff_t>(others / 2), dome(radiance));
  return LightSet(std::move(lights), {}, 4);
}

std::vector<LightSample> drawn(const LightSet& set, const Vec3f& p, const Horizon& horizon,
                               const std::array<float, 4>& u, const LightSampleContext& at) {
  std::vector<LightSample> samples;
  for (size_t k = 0; k < set.draws(at); ++k)
    if (const auto s = set.draw(k, p, horizon, u, at)) samples.push_back(*s);
  return samples;
}

TEST(LightSet, ConstantDomesTakeNoPartInTheChoiceOfALight) {
  const Vec3f p(0, 0, -3);
  for (const size_t others : {0u, 1u, 3u, 4u, 20u, 300u}) {
    const LightSet set = domed(4, others, 1e-6f);
    const auto domes = [&](ConstantDomes how) {
      int count = 0;
      for (const LightSample& s : drawn(set, p, {Vec3f(0, 0, 1), Vec3f(0, 0, 1)}, {0.7f, 0.3f, 0.4f, 0}, how)) {
        if (!std::isinf(s.distance)) continue;
        EXPECT_TRUE(s.of_constant_dome);
        EXPECT_EQ(s.pdf, pdf_uniform_sphere()) << others;
        ++count;
      }
      return count;
    };
    EXPECT_EQ(domes(ConstantDomes::sampled), 1) << others;
    EXPECT_EQ(domes(ConstantDomes::bsdf_sampling_only), 0) << others;
    for (const float u : {0.0f, 0.4f, 0.999f})
      if (const auto chosen = set.sample(p, u, {0.3f, 0.4f})) {
        EXPECT_TRUE(std::isfinite(chosen->distance)) << others;
      }
    std::vector<float> pdfs;
    const auto keep = [&](float pdf) { return pdfs.push_back(pdf), 1.0f; };
    testing::emitted_light(set, {p, {0, 1, 0}}, true, false, ConstantDomes::sampled, keep);
    testing::emitted_light(set, {p, {0, 1, 0}}, true, false, ConstantDomes::bsdf_sampling_only, keep);
    EXPECT_EQ(pdfs, (std::vector<float>{pdf_uniform_sphere(), 0})) << others;
  }
}

// Few by their importance, many by a tree.
TEST(LightSet, LightsAreChosenByTheMeanOfTheirScalesForLobes) {
  for (const size_t count : {3u, 300u}) {
    std::vector<Light> alike, unlike;
    LightSet::Traits traits;
    const LobeScales kinds[] = {{0, 0}, {4, 0}, {1, 1}};
    for (size_t i = 0; i < count; ++i) {
      traits.scales.push_back(kinds[i % 3]);
      alike.push_back(sphere(1));
      unlike.push_back(sphere(static_cast<float>(kinds[i % 3].mean())));
    }
    const LightSet scaled(alike, traits), stronger(unlike, {});
    for (size_t i = 0; i < count; ++i)
      EXPECT_EQ(scaled.choice_probability(i, {0, 0, -3}), stronger.choice_probability(i, {0, 0, -3}))
          << count << ": " << i;
  }
}

TEST(LightSet, ConstantDomesAreSampledByTheCosineToALobe) {
  const LightSet alone({dome(4)}, {}, 8), chosen({sphere(1), dome(4)}, {});
  const Vec3f p(0, 0, -30), n = normalize(Vec3f(-0.6f, 0.3f, -0.8f));
  const LightSampleContext search{ConstantDomes::sampled, n};
  for (const LightSet* set : {&alone, &chosen})
    for (const Vec2f& u : {Vec2f(0.1f, 0.2f), Vec2f(0.5f, 0.9f), Vec2f(0.95f, 0.4f)}) {
      const std::vector<LightSample> all = drawn(*set, p, {n, n}, {0.999f, u.x, u.y, 0}, search);
      ASSERT_FALSE(all.empty());
      const LightSample* const sampled = &all.back();
      EXPECT_NEAR(sampled->pdf / (dot(sampled->wi, n) * kInvPi), 1, 1e-5f);
      std::vector<float> pdfs;
      const auto keep = [&](float pdf) { return pdfs.push_back(pdf), 1.0f; };
      testing::emitted_light(*set, {p, sampled->wi}, true, false, search, keep);
      testing::emitted_light(*set, {p, -sampled->wi}, true, false, search, keep);
      ASSERT_EQ(pdfs.size(), 2u);
      EXPECT_NEAR(pdfs[0] / sampled->pdf, 1, 1e-5f);
      EXPECT_EQ(pdfs[1], 0) << "below the lobe";
    }
}

// Alone, chosen of few, chosen by a tree, and with a shadow link.
TEST(LightSet, RaysThatMeetALightHaveThePdfThatItsSamplesHaveForALobe) {
  const Vec3f p(0.4f, -0.2f, -4), n = normalize(Vec3f(0.6f, 0, 0.8f));
  const RectDiskLight rect(described(LightType::rect, 1), kOrigin);
  std::vector<Light> many{rect};
  for (int i = 1; i < 200; ++i) {
    LightParameters behind = described(LightType::sphere, 0.1f);
    behind.light_to_world = Matrix4d(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 3 * i, 0, -100, 1);
    many.emplace_back(SphereLight(behind, kOrigin));
  }
  const std::vector<Light> few(many.begin(), many.begin() + 3);
  const LightSet sets[] = {LightSet({rect}, {}, 8), LightSet(few, {}), LightSet(many, {}),
                           LightSet({rect}, {.visible_to_camera = {}, .shadow_links = {1}}, 8)};
  for (const LightSet& set : sets) {
    const LightSampleContext search{ConstantDomes::sampled, n};
    std::optional<LightSample> sampled;
    for (float choice = 0.01f; choice < 1 && !sampled; choice += 0.02f)
      for (const LightSample& s : drawn(set, p, {n, n}, {choice, 0.9f, 0.3f, 0}, search))
        if (s.wi.z > 0) sampled = s;
    ASSERT_TRUE(sampled);
    const auto met = [&](const LightSampleContext& by) {
      std::vector<float> pdfs;
      const auto keep = [&](float pdf) { return pdfs.push_back(pdf), 1.0f; };
      const Ray ray{p, sampled->wi};
      testing::emitted_light(set, ray, true, false, by, keep);
      if (set.has_shadow_links())
        set.each_emitted_with_links(
            ray, by, keep, [](uint32_t, float) { return Rgb(1.0f); }, nullptr, [](size_t, const Rgb&) {});
      EXPECT_EQ(pdfs.size(), 1u);
      return pdfs.empty() ? 0 : pdfs[0];
    };
    EXPECT_NEAR(met(search) / sampled->pdf, 1, 1e-4f);
    EXPECT_GT(std::abs(met(ConstantDomes::sampled) / sampled->pdf - 1), 0.01f);
  }
}

// Lights near the origin, and planes through points around them.
TEST(LightSet, OnlyLightsBelowTheHorizonAreLeftOut) {
  LightParameters rect = described(LightType::rect, 1);
  rect.width = 3;
  rect.light_to_world = Matrix4d(1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0.5, 0, 0, 1);
  const LightSet sets[] = {LightSet({RectDiskLight(rect, kOrigin)}, {}, 8), LightSet({sphere(1)}, {}, 8)};
  Rng rng(1, 2);
  const auto direction = [&] { return sample_uniform_sphere({rng.uniform(), rng.uniform()}); };
  for (const LightSet& set : sets) {
    int kept = 0, left_out = 0;
    for (int i = 0; i < 4000; ++i) {
      const Vec3f p = direction() * 2.5f;
      const Horizon horizon{direction(), direction()};
      const Vec2f u(rng.uniform(), rng.uniform());
      const auto s = set.sample(p, 0, u);
      if (!s) continue;
      const bool visited = !drawn(set, p, horizon, {0, u.x, u.y, 0}, ConstantDomes::sampled).empty();
      const bool above = dot(s->wi, horizon[0]) > 0 && dot(s->wi, horizon[1]) > 0;
      EXPECT_TRUE(visited || !above);
      (visited ? kept : left_out) += 1;
    }
    EXPECT_GT(kept, 500);
    EXPECT_GT(left_out, 500);
  }
}

TEST(LightSet, FindsMeshLightsByInstance) {
  const auto mesh = [](uint32_t instance, float z) {
    return MeshLight(instance, {{{0, 0, z}, {1, 0, z}, {0, 1, z}, Rgb(1.0f)}}, {4});
  };
  const LightSet set({mesh(9, 1), sphere(1), mesh(2, -2)}, {});
  const Vec3f p(0.1f, 0.2f, 0);
  const Ray up{p, {0, 0, 1}}, down{p, {0, 0, -1}};
  EXPECT_NEAR(set.mesh_light_pdf(up, 1, 9, 4), 2 * set.choice_probability(0, p), 1e-6f);
  EXPECT_NEAR(set.mesh_light_pdf(down, 2, 2, 4), 8 * set.choice_probability(2, p), 1e-6f);
  EXPECT_GT(set.choice_probability(0, p), set.choice_probability(2, p));
  EXPECT_EQ(set.mesh_light_pdf(up, 1, 9, 3), 0);
  EXPECT_EQ(set.mesh_light_pdf(up, 1, 5, 4), 0);
  EXPECT_TRUE(is_black(testing::emitted_light(LightSet({mesh(1, 1)}, {}), {{0.1f, 0.1f, 0}, {0, 0, 1}}, true, false,
                                              ConstantDomes::sampled, kUnweighted)))
      << "the surface emits, not the light";
}

}  // namespace
}  // namespace alabaster
