#include "core/light/moving_light.h"

#include <gtest/gtest.h>

#include "core/light/light_set.h"
#include "core/sampling/pixel_sampler.h"
#include "testenv/support/emitted_light.h"

namespace alabaster {
namespace {

const LightType kTypes[] = {LightType::rect, LightType::sphere, LightType::disk, LightType::cylinder,
                            LightType::distant};

double random(Rng& rng, double from, double to) {
  return from + (to - from) * static_cast<double>(rng.uniform());
}

/// Turns, travels and changes its size unevenly.
LightParameters moving(LightType type, Rng& rng) {
  LightParameters d;
  d.type = type;
  d.angle = 20;
  const Vec3d axis(random(rng, -1, 1), random(rng, -1, 1), random(rng, 0.1, 1));
  const Vec3d from(random(rng, -9, 9), random(rng, -9, 9), random(rng, -9, 9));
  for (int i = 0; i < 3; ++i) {
    Matrix4d size;
    for (int k = 0; k < 3; ++k) size[k][k] = random(rng, 0.2, 2);
    d.poses.push_back(size * Matrix4d().setAxisAngle(axis, 0.4 * i) *
                      Matrix4d().setTranslation(from + Vec3d(i, 0.5 * i * i, -i)));
  }
  d.light_to_world = d.poses.front();
  return d;
}

// Of the light where it stands at random times.
TEST(MovingLight, BoxHoldsTheLightOverTheShutter) {
  for (const LightType type : kTypes) {
    if (type == LightType::distant) continue;
    Rng rng(3, static_cast<uint32_t>(type));
    int sampled = 0;
    for (int i = 0; i < 300; ++i) {
      const MovingLight light(moving(type, rng), Vec3d(1, 2, 3));
      BoundsDouble box = light.extent().box;
      const double slack = 1e-5 * length(box.extent());
      box.extend(box.lower - Vec3d(slack)), box.extend(box.upper + Vec3d(slack));
      for (int k = 0; k < 20; ++k) {
        const Vec3f p(40 * rng.uniform() - 20, 40 * rng.uniform() - 20, 40 * rng.uniform() - 20);
        const auto s = light.sample(p, {rng.uniform(), rng.uniform()}, {0, 0, 0}, rng.uniform());
        if (!s) continue;
        ++sampled;
        EXPECT_GT(light.importance(p), 0) << "it would not be chosen";
        const Vec3d at = Vec3d(p) + Vec3d(s->wi) * static_cast<double>(s->distance);
        for (int c = 0; c < 3; ++c) {
          EXPECT_GE(at[c], box.lower[c]);
          EXPECT_LE(at[c], box.upper[c]);
        }
      }
    }
    EXPECT_GT(sampled, 1000);
  }
}

// As the hits of MIS ask: 3 lights are all sampled, 50 chosen by importance, 300 by the tree.
TEST(MovingLight, AHitHasThePdfOfTheSampleAtItsTime) {
  for (const uint32_t count : {3u, 50u, 300u}) {
    Rng rng(count, 1);
    std::vector<Light> lights;
    for (uint32_t i = 0; i < count; ++i)
      lights.push_back(make_light(moving(kTypes[i % std::size(kTypes)], rng), Vec3d(0, 0, 0)));
    const LightSet set(std::move(lights), {}, 4);
    int compared = 0, missed = 0;
    for (int k = 0; k < 2000; ++k) {
      const Vec3f p(30 * rng.uniform() - 15, 30 * rng.uniform() - 15, 30 * rng.uniform() - 15);
      const float time = rng.uniform();
      const LightSampleContext at(ConstantDomes::sampled, {0, 0, 0}, time);
      const Horizon open{Vec3f(0, 0, 0), Vec3f(0, 0, 0)};
      const std::array<float, 4> u{rng.uniform(), rng.uniform(), rng.uniform(), 0};
      const auto s = set.draw(static_cast<size_t>(k) % set.draws(at), p, open, u, at);
      if (!s) continue;
      const bool infinite = !std::isfinite(s->distance);
      const auto nearest = [&](float when) {
        float apart = 1;
        const Ray ray{p, s->wi, infinite ? kInfinity : s->distance * 1.001f, when};
        (void)testing::emitted_light(set, ray, infinite, false, at, [&](float pdf) {
          apart = std::min(apart, std::abs(pdf / s->pdf - 1));
          return 1.0f;
        });
        return apart;
      };
      missed += nearest(time) < 2e-3f ? 0 : 1;
      compared += nearest(time < 0.5f ? time + 0.5f : time - 0.5f) < 2e-3f ? 0 : 1;
    }
    EXPECT_LE(missed, 4) << "of " << count << ": edges, where rounding decides";
    EXPECT_GT(compared, 100) << "at another time it is elsewhere";
  }
}

// Its turning changes nothing.
TEST(MovingLight, AConstantDomeStandsStill) {
  Rng rng(1, 1);
  EXPECT_TRUE(is_constant_dome(make_light(moving(LightType::dome, rng), Vec3d(0, 0, 0))));
}

}  // namespace
}  // namespace alabaster
