// The twin of a walk in a half-space obtains the half-space's albedo on average, whatever body the walk itself is in.
#include <gtest/gtest.h>

#include "testenv/support/analytic_bodies.h"
#include "testenv/support/lone_body.h"
#include "testenv/support/path_tracer.h"
#include "testenv/support/z_test.h"

namespace alabaster::testing {
namespace {

const Rgb kScatterDistance(1.0f, 0.35f, 0.2f);
const Rgb kSkin(0.9f, 0.6f, 0.45f), kMarble(0.99f, 0.97f, 0.9f), kDark(0.4f, 0.15f, 0.03f);

WalkSettings with(bool guiding, bool sphere_steps) {
  WalkSettings settings;
  settings.guiding = guiding;
  settings.sphere_steps = sphere_steps;
  return settings;
}
const WalkSettings kSettings[] = {with(false, false), with(true, false), with(false, true), with(true, true)};

struct TwinMeans {
  RunningStatistics channel[3];
};

/// `plane`: normal of the twin's half-space.
template <class Tracer>
TwinMeans twins_in(const Tracer& body, const WalkMedium& medium, const WalkSettings& settings, const Vec3f& to_light,
                   uint64_t seed, const Vec3f& plane = {0, 0, -1}) {
  TwinMeans means;
  Rng rng(run_seed(seed), 91);
  RenderCounters counters;
  for (int i = 0; i < run_samples(40000); ++i) {
    Tracer tracer = body;
    SubsurfaceNumbers numbers(rng);
    WalkStart start = start_walk(numbers);
    HalfSpaceTwin twin(plane, medium);
    start.to_light = to_light;
    start.twin = &twin;
    run_walk(tracer, start, medium, settings, numbers, counters);
    rng = numbers.rng();
    for (size_t c = 0; c < 3; ++c) means.channel[c].add(twin.throughput()[c]);
  }
  return means;
}

// Sphere steps are off by 1e-4 (tables/shortcuts.cpp).
void expect_albedo(const TwinMeans& means, const Rgb& albedo, bool sphere_steps) {
  for (int c = 0; c < 3; ++c) {
    const ZTestResult result =
        z_test(means.channel[c], static_cast<double>(albedo[c]), {.slack = sphere_steps ? 1e-4 : 1e-5});
    EXPECT_TRUE(plausible(result)) << c;
  }
}

template <class Tracer>
void expect_albedo_in(const Tracer& body, uint64_t seed) {
  for (const Rgb& albedo : {kSkin, kMarble, kDark})
    for (const WalkSettings& settings : kSettings) {
      SCOPED_TRACE(++seed);
      const WalkMedium medium = make_medium(albedo, kScatterDistance, AlbedoInversion::exact);
      expect_albedo(twins_in(body, medium, settings, {0, 0, 0}, seed), albedo, settings.sphere_steps);
    }
}

TEST(HalfSpaceTwin, ObtainsTheAlbedoBesideWalksInAnyBody) {
  expect_albedo_in(SlabTracer(2), 100);
  expect_albedo_in(EdgeTracer(0.5), 200);
  expect_albedo_in(SphereTracer(3), 300);
  expect_albedo_in(SphereTracer(0.3), 400);
}

TEST(HalfSpaceTwin, ObtainsTheAlbedoBesideWalksThatACapEnds) {
  WalkSettings settings;
  settings.safety_cap = 3;
  const WalkMedium medium = make_medium(kSkin, kScatterDistance, AlbedoInversion::exact);
  expect_albedo(twins_in(SphereTracer(3), medium, settings, {0, 0, 0}, 450), kSkin, true);
}

TEST(HalfSpaceTwin, ObtainsTheAlbedoBesideWalksThatAreGuidedElsewhere) {
  const WalkMedium medium = make_medium(kSkin, kScatterDistance, AlbedoInversion::exact);
  uint64_t seed = 500;
  for (const Vec3f& to_light : {Vec3f(0, 0, 1), Vec3f(0.8f, 0, 0.6f)})
    expect_albedo(twins_in(SlabTracer(4), medium, with(true, true), to_light, ++seed), kSkin, true);
}

// Many of the lobe's directions lead out of the body and are mirrored, which the twin must not follow.
TEST(HalfSpaceTwin, TwinUnderATiltedNormalObtainsTheAlbedo) {
  const WalkMedium medium = make_medium(kSkin, kScatterDistance, AlbedoInversion::exact);
  const BodyInWorld ball(sphere_mesh(1, 24, false));
  SubsurfaceEntry entry = ball.entry({0, 0, -3}, {0, 0, 1}, medium);
  entry.ns = normalize(entry.hit.ng + frame_from_normal(entry.hit.ng).s * 2.0f);
  entry.throughput = {0.5f, 2, 1};
  Rng rng(run_seed(700), 91);
  RenderCounters counters;
  TwinMeans means;
  for (int i = 0; i < run_samples(60000); ++i) {
    Rgb twin(0.0f);
    carry(RandomWalk{{}, nullptr, &twin}, ball.body(), entry, rng, counters);
    for (int c = 0; c < 3; ++c) means.channel[c].add(static_cast<double>(twin[c] / entry.throughput[c]));
  }
  expect_albedo(means, kSkin, true);
}

struct PixelMeans {
  RunningStatistics channel[3];
  double variance() const { return channel[0].variance() + channel[1].variance() + channel[2].variance(); }
};

/// In blocks of 64 samples: within one they depend on each other.
PixelMeans pixel(PathTracer* tracer, bool twins, uint32_t blocks) {
  tracer->settings.walk.twins = twins;
  tracer->settings.max_depth = 3;
  PixelMeans means;
  for (uint32_t block = 0; block < run_samples(blocks); ++block) {
    Rgb sum(0.0f);
    for (uint32_t i = 0; i < 64; ++i) sum += tracer->trace(block * 64 + i).color;
    for (int c = 0; c < 3; ++c) means.channel[c].add(static_cast<double>(sum[c]) / 64);
  }
  return means;
}

LightParameters lamp_of(float intensity) {
  LightParameters lamp;
  lamp.type = LightType::rect;
  lamp.intensity = intensity;
  lamp.light_to_world.setTranslation(Vec3d(0, 0, 3));
  return lamp;
}

DisneyParameters skin_of(float reach) {
  DisneyParameters skin;
  skin.base_color = kSkin;
  skin.scatter_distance = kScatterDistance * reach;
  return skin;
}

void expect_same_means(const PixelMeans& with, const PixelMeans& without) {
  for (int c = 0; c < 3; ++c) {
    const double error = std::hypot(with.channel[c].standard_error(), without.channel[c].standard_error());
    EXPECT_LT(error, 0.01 * with.channel[c].mean()) << c << ": the test would see no bias";
    EXPECT_TRUE(plausible(z_test(with.channel[c], without.channel[c]))) << c;
  }
}

// A ball under a lamp and a sky, from where it is nearly flat to where it is thin, beside a glossy floor that shows it
// to itself.
TEST(HalfSpaceTwin, ChangesTheNoiseOfAPixelAndNotItsMean) {
  // Light from the lamp, or mostly from the sky.
  const std::pair<float, float> cases[] = {{0.01f, 40.0f}, {0.1f, 40.0f}, {1.0f, 40.0f}, {0.01f, 0.1f}, {1.0f, 0.1f}};
  for (const auto& [reach, intensity] : cases) {
    SCOPED_TRACE(reach * 1000 + intensity);
    SceneBuilder b;
    DisneyParameters mirror;
    mirror.metallic = 1;
    mirror.roughness = 0.3f;
    b.add(b.prototype(sphere_mesh(1, 64, true)), b.material(skin_of(reach)));
    b.add(b.prototype(plane_mesh(2)), b.material(mirror), Matrix4d().setTranslation(Vec3d(0, -1, 0)));
    b.add(lamp_of(intensity)).add(constant_dome(0.2f, false));
    PathTracer tracer(b.snapshot(), {0.5, 1, 3});
    const PixelMeans with = pixel(&tracer, true, 600), without = pixel(&tracer, false, 600);
    expect_same_means(with, without);
    if (reach < 0.05f) {
      EXPECT_LT(with.variance(), 0.3 * without.variance()) << "where the ball is flat";
    }
  }
}

// One channel does not scatter; one light of six is chosen; a lamp is a mesh that nearly touches the ball.
TEST(HalfSpaceTwin, ChangesNoMeanWhateverLightsTheBall) {
  for (const AlbedoInversion inversion : {AlbedoInversion::chiang2016, AlbedoInversion::exact}) {
    SCOPED_TRACE(static_cast<int>(inversion));
    SceneBuilder b;
    DisneyParameters skin = skin_of(0.02f), glowing;
    skin.scatter_distance.b = 0;
    glowing.emission = Rgb(2.0f);
    b.add(b.prototype(sphere_mesh(1, 64, true)), b.material(skin));
    b.add(b.prototype(sphere_mesh(0.2f, 8, false)), b.material(glowing),
          Matrix4d().setTranslation(Vec3d(0.2, 0.9, 0.9)));
    for (int i = 0; i < 5; ++i) {
      LightParameters lamp = lamp_of(20);
      lamp.light_to_world.setTranslation(Vec3d(i - 2, 1, 3));
      b.add(lamp);
    }
    PathTracer tracer(b.snapshot(), {0.5, 1, 3});
    tracer.settings.inversion = inversion;
    const PixelMeans with = pixel(&tracer, true, 600), without = pixel(&tracer, false, 600);
    expect_same_means(with, without);
    EXPECT_LT(with.variance(), without.variance());
  }
}

// Every walk is followed to its end, and every exit sees the sky that the entry saw. The unevenness of the
// exit lobe is left.
TEST(HalfSpaceTwin, LeavesHardlyAnyNoiseUnderAnEvenSky) {
  SceneBuilder b;
  DisneyParameters skin = matt(kSkin);
  skin.scatter_distance = kScatterDistance * 0.01f;
  b.add(b.prototype(plane_mesh(40)), b.material(skin)).add(constant_dome(1, false));
  PathTracer tracer(b.snapshot(), {0, 5, 0.01});
  const PixelMeans with = pixel(&tracer, true, 20), without = pixel(&tracer, false, 20);
  EXPECT_LT(with.variance(), 0.01 * without.variance());
}

// The lobe is not about the normal of this half-space.
TEST(HalfSpaceTwin, InTheWrongHalfSpaceIsNoticed) {
  const WalkMedium medium = make_medium(kSkin, kScatterDistance, AlbedoInversion::exact);
  const TwinMeans means = twins_in(SphereTracer(3), medium, {}, {0, 0, 0}, 600, {0.6f, 0, -0.8f});
  int failures = 0;
  for (int c = 0; c < 3; ++c)
    failures += noticed(z_test(means.channel[c], static_cast<double>(kSkin[c]), {.slack = 1e-4})) ? 1 : 0;
  EXPECT_GT(failures, 0);
}

TEST(HalfSpaceTwin, TwinInAHalfSpaceIsTheWalk) {
  for (const Rgb& albedo : {kSkin, kMarble})
    for (const WalkSettings& settings : kSettings) {
      const WalkMedium medium = make_medium(albedo, kScatterDistance, AlbedoInversion::exact);
      Rng rng(run_seed(7), 91);
      RenderCounters counters;
      for (int i = 0; i < run_samples(2000); ++i) {
        SlabTracer tracer;
        SubsurfaceNumbers numbers(rng);
        WalkStart start = start_walk(numbers);
        HalfSpaceTwin twin(-start.inward, medium);
        start.twin = &twin;
        const auto exit = run_walk(tracer, start, medium, settings, numbers, counters);
        rng = numbers.rng();
        for (size_t c = 0; c < 3; ++c) ASSERT_NEAR(twin.throughput()[c], exit ? exit->throughput[c] : 0, 1e-9) << i;
      }
    }
}

}  // namespace
}  // namespace alabaster::testing
