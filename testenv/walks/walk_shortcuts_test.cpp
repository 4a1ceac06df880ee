// The shortcuts of the walk, guiding and sphere steps, must give the same answers as walks without them.
#include <gtest/gtest.h>

#include "testenv/support/analytic_bodies.h"
#include "testenv/support/chi_square.h"
#include "testenv/support/transport_solution.h"
#include "testenv/support/walk_pdfs.h"
#include "testenv/support/z_test.h"

namespace alabaster::testing {
namespace {

WalkSettings with(bool guiding, bool sphere_steps) {
  WalkSettings settings;
  settings.guiding = guiding;
  settings.sphere_steps = sphere_steps;
  return settings;
}

struct Outcome {
  RunningStatistics out[3];   // per channel, of all exits
  RunningStatistics through;  // channel 0 out of side 1
  RunningStatistics
      beyond_edge[3];  // out of side 0, at least half a unit to one side, as if lit across a shadow's edge
  RenderCounters counters;
};

/// Walks in copies of `body`; `run` makes one walk from a tracer and a start.
template <class Tracer, class Run>
Outcome walk_many(const Tracer& body, const Run& run, int paths, uint64_t seed) {
  Outcome outcome;
  Rng rng(run_seed(seed), 78);
  for (int i = 0; i < run_samples(paths); ++i) {
    Tracer tracer = body;
    SubsurfaceNumbers numbers(rng);
    const std::optional<WalkLoopExit<BodyHit>> end = run(tracer, start_walk(numbers), numbers, outcome.counters);
    rng = numbers.rng();
    const double side = end ? end->hit.side : 0;
    const bool beyond = end && side == 0 && tracer.position().x + end->direction.x * end->hit.t > 0.5;
    for (size_t c = 0; c < 3; ++c) {
      outcome.out[c].add(end ? end->throughput[c] : 0);
      outcome.beyond_edge[c].add(beyond ? end->throughput[c] : 0);
    }
    outcome.through.add(end && side == 1 ? end->throughput[0] : 0);
  }
  EXPECT_EQ(outcome.counters.walk_lost, 0u);
  EXPECT_EQ(outcome.counters.walk_safety_cap, 0u);
  return outcome;
}

template <class Tracer>
Outcome walk_many(const Tracer& body, const Medium& medium, const WalkSettings& settings, int paths, uint64_t seed) {
  const auto run = [&](Tracer& tracer, const WalkStart& start, SubsurfaceNumbers& numbers, RenderCounters& counters) {
    return run_walk(tracer, start, medium, settings, numbers, counters);
  };
  return walk_many(body, run, paths, seed);
}

void expect_mean(const RunningStatistics& values, double expected, double slack = 1e-6) {
  const ZTestResult result = z_test(values, expected, {.slack = slack});
  EXPECT_TRUE(plausible(result));
}

/// Two runs that should have the same mean.
void expect_same_mean(const RunningStatistics& a, const RunningStatistics& b) {
  EXPECT_TRUE(plausible(z_test(a, b)));
}

const Rgb kScatterDistance(1.0f, 0.35f, 0.2f);
const Rgb kSkin(0.9f, 0.6f, 0.45f);

Medium medium_of(const Rgb& albedo) {
  return make_medium(albedo, kScatterDistance, AlbedoInversion::exact);
}

TEST(Dwivedi, SamplerDrawsFromItsPdf) {
  constexpr double kComplements[] = {1.2e-5, 2.1e-3, 0.12, 0.4, 0.69};  // guided at all: 1e-5 .. 0.7
  for (const double complement : kComplements) {
    const DwivediMode mode = dwivedi_mode(complement);
    ChiSquareOptions options;
    options.pole_exponent = 3;
    const auto sample = [&](Rng& rng) -> std::optional<Vec3f> {
      const double mu = sample_dwivedi(rng.uniform(), mode);
      return direction_at(Frame(), mu, rng.uniform());
    };
    const auto result = chi_square_sphere(
        sample, [&](const Vec3f& w) { return static_cast<float>(pdf_dwivedi(w.z, mode) / kTwoPi); }, options);
    EXPECT_TRUE(plausible(result)) << complement;
    // The test detects the pdf of a slightly darker medium, where there is a lobe.
    if (complement < 1e-2) continue;
    const DwivediMode other = dwivedi_mode(complement * 1.3);
    EXPECT_TRUE(noticed(chi_square_sphere(
        sample, [&](const Vec3f& w) { return static_cast<float>(pdf_dwivedi(w.z, other) / kTwoPi); }, options)))
        << complement;
  }
}

TEST(Dwivedi, JumpsLandWithTheirPdf) {
  for (const double reach : {0.0, 0.3, 2.0, 9.0}) {
    ChiSquareOptions options;
    options.pole_exponent = 2;
    const auto result = chi_square_sphere(
        [&](Rng& rng) -> std::optional<Vec3f> {
          const double mu = sample_exponential_cosine(rng.uniform(), reach);
          return direction_at(Frame(), mu, rng.uniform());
        },
        [&](const Vec3f& w) {
          return static_cast<float>(exponential_cosine_factor(w.z, reach)) * pdf_uniform_sphere();
        },
        options);
    EXPECT_TRUE(plausible(result)) << reach;
  }
}

TEST(WalkShortcuts, AThinSlabsTransmissionGainsFromTheBackwardShare) {
  // With guiding towards the entry surface alone, transmission would be many times noisier than without guiding.
  const double complement = one_minus_alpha(0.5, AlbedoInversion::exact);
  const Outcome plain = walk_many(SlabTracer(8), unit_medium(complement), with(false, false), 60000, 280);
  const Outcome guided = walk_many(SlabTracer(8), unit_medium(complement), with(true, false), 60000, 281);
  const auto cost = [](const Outcome& o) { return o.through.variance() * static_cast<double>(o.counters.walk_rays); };
  EXPECT_LT(cost(guided), cost(plain));
}

/// Walks guided to light in direction `to_light`.
Outcome walk_to_light(const SlabTracer& body, const Medium& medium, const Vec3f& to_light, const WalkSettings& settings,
                      uint64_t seed) {
  const auto run = [&](SlabTracer& tracer, WalkStart start, SubsurfaceNumbers& numbers, RenderCounters& counters) {
    start.to_light = to_light;
    return run_walk(tracer, start, medium, settings, numbers, counters);
  };
  return walk_many(body, run, 60000, seed);
}

TEST(WalkShortcuts, GuidedToLightAnywhereASlabGivesWhatItShould) {
  constexpr double kThickness = 4;
  const double complement = one_minus_alpha(0.8, AlbedoInversion::exact);
  const SlabAnswer answer = solve_slab(kThickness, complement);
  uint64_t seed = 400;
  for (const Vec3f& to_light : {Vec3f(0, 0, 1), Vec3f(1, 0, 0), Vec3f(0, -0.6f, 0.8f)})
    for (const WalkSettings& settings : {with(true, false), with(true, true)}) {
      SCOPED_TRACE(++seed);
      const Outcome walked = walk_to_light(SlabTracer(kThickness), unit_medium(complement), to_light, settings, seed);
      const double slack = answer.error + (settings.sphere_steps ? 1e-4 : 0);
      expect_mean(walked.through, answer.transmittance, slack);
      expect_mean(walked.out[0], answer.reflectance + answer.transmittance, 2 * slack);
    }
}

TEST(WalkShortcuts, GuidedToLightInColourIsThePlainWalk) {
  const Outcome plain = walk_many(SlabTracer(2), medium_of(kSkin), with(false, false), 60000, 410);
  uint64_t seed = 411;
  for (const Vec3f& to_light : {Vec3f(0, 0, 1), Vec3f(0.8f, 0, 0.6f)}) {
    SCOPED_TRACE(++seed);
    const Outcome walked = walk_to_light(SlabTracer(2), medium_of(kSkin), to_light, with(true, false), seed);
    for (int c = 0; c < 3; ++c) {
      expect_same_mean(walked.out[c], plain.out[c]);
      expect_same_mean(walked.beyond_edge[c], plain.beyond_edge[c]);
    }
    expect_same_mean(walked.through, plain.through);
  }
}

TEST(WalkShortcuts, GuidedToLightBehindASlabItsTransmissionHasLessNoise) {
  const Medium medium = unit_medium(one_minus_alpha(0.5, AlbedoInversion::exact));
  const Outcome plain = walk_many(SlabTracer(8), medium, with(false, false), 60000, 420);
  const Outcome guided = walk_to_light(SlabTracer(8), medium, Vec3f(0, 0, 1), with(true, false), 421);
  const auto cost = [](const Outcome& o) { return o.through.variance() * static_cast<double>(o.counters.walk_rays); };
  EXPECT_LT(cost(guided), 0.6 * cost(plain));
}

TEST(WalkShortcuts, ExtremesGiveNoNan) {
  const float infinity = std::numeric_limits<float>::infinity();
  const Rgb distances[] = {{1e-38f, 1.0f, infinity}, {1e-45f, 3e38f, 1.0f}, {1e-30f, 1e30f, 0.0f}, Rgb(1e-4f)};
  const Rgb albedos[] = {Rgb(0.1f), Rgb(1.0f), {1e-38f, 0.5f, 1.0f}, {0.9f, 0.99f, 0.8f}};
  Rng rng(run_seed(340), 78);
  for (const Rgb& distance : distances)
    for (const Rgb& albedo : albedos) {
      RenderCounters counters;
      WalkSettings settings;
      settings.safety_cap = 2000;
      const Medium medium = make_medium(albedo, distance, AlbedoInversion::exact);
      for (int i = 0; i < 500; ++i) {
        SphereTracer tracer(1);
        const auto end = walk_body_with_shortcuts(tracer, medium, settings, rng, counters);
        if (!end) continue;
        for (const double channel : end->throughput) ASSERT_TRUE(std::isfinite(channel) && channel >= 0);
      }
      EXPECT_EQ(counters.walk_lost, 0u);
    }
}

/// Weights each segment as if it were a tenth longer.
class WrongGuidedSegment : public GuidedSegment {
 public:
  using GuidedSegment::GuidedSegment;
  ChannelValues scatter_throughput(double t) const { return GuidedSegment::scatter_throughput(1.1 * t); }
  ChannelValues exit_throughput(double t) const { return GuidedSegment::exit_throughput(1.1 * t); }
};

TEST(WalkShortcuts, AWrongPdfIsNoticed) {
  const Medium medium = medium_of(kSkin);
  const auto run = [&](SlabTracer& tracer, const WalkStart& start, SubsurfaceNumbers& numbers,
                       RenderCounters& counters) {
    return WalkLoop<WalkShortcuts{true, false}, WrongGuidedSegment, SlabTracer>(tracer, start, medium, {}, numbers,
                                                                                counters)
        .run();
  };
  const Outcome walked = walk_many(SlabTracer(), run, 60000, 350);
  int failures = 0;
  for (int c = 0; c < 3; ++c) failures += noticed(z_test(walked.out[c], kSkin[c])) ? 1 : 0;
  EXPECT_GT(failures, 0);
}

}  // namespace
}  // namespace alabaster::testing
