// The renderer's own walk in bodies with answers by quadrature: half-space, slab, sphere.
#include <gtest/gtest.h>

#include "testenv/support/albedo_table.h"
#include "testenv/support/analytic_bodies.h"
#include "testenv/support/half_space.h"
#include "testenv/support/transport_solution.h"
#include "testenv/support/z_test.h"

namespace alabaster::testing {
namespace {

struct BodyStatistics {
  RunningStatistics out[3];   // throughput per channel, both sides of the body
  RunningStatistics through;  // channel 0 of exits on side 1
  RunningStatistics uncollided;
  RenderCounters counters;
};

template <class Segment = ChromaticSegment, class MakeTracer>
BodyStatistics walk_many(const MakeTracer& make_tracer, const Medium& medium, const WalkSettings& settings, int paths,
                         uint64_t seed) {
  BodyStatistics statistics;
  Rng rng(run_seed(seed), 77);
  for (int i = 0; i < run_samples(paths); ++i) {
    auto tracer = make_tracer();
    const auto end = walk_body<Segment>(tracer, medium, settings, rng, statistics.counters);
    for (size_t c = 0; c < 3; ++c) statistics.out[c].add(end ? end->throughput[c] : 0);
    statistics.through.add(end && end->hit.side == 1 ? end->throughput[0] : 0);
    statistics.uncollided.add(end && end->events == 0 ? end->throughput[0] : 0);
  }
  EXPECT_EQ(statistics.counters.walk_lost, 0u);
  if (settings.safety_cap == WalkSettings().safety_cap) {
    EXPECT_EQ(statistics.counters.walk_safety_cap, 0u);
  }
  return statistics;
}

void expect_mean(const RunningStatistics& values, double expected, double slack = 1e-6) {
  const ZTestResult result = z_test(values, expected, {.slack = slack});
  EXPECT_TRUE(plausible(result));
}

constexpr auto kHalfSpace = [] { return SlabTracer(); };

// promise: trade_off.bias.walk
TEST(SlabAlbedo, ObtainsWhatEachInversionReallyGives) {
  uint64_t seed = 1;
  for (const double asked : {0.2, 0.5, 0.8, 0.95})
    for (const AlbedoInversion inversion : {AlbedoInversion::chiang2016, AlbedoInversion::exact}) {
      const double complement = one_minus_alpha(asked, inversion);
      const double expected = half_space_albedo(complement);
      // The expected albedo: the table's column for eq. 1, the requested albedo for the exact inversion.
      double table = asked;
      if (inversion == AlbedoInversion::chiang2016)
        for (const AlbedoRow& row : kAlbedoTable)
          if (row.albedo == asked) table = row.chiang2016;
      EXPECT_NEAR(expected, table, 5.1e-6);
      const Medium medium = make_medium(Rgb(static_cast<float>(asked)), {0.7f, 0, 0}, inversion);
      const BodyStatistics walked = walk_many(kHalfSpace, medium, {}, 100000, ++seed);
      SCOPED_TRACE(asked);
      expect_mean(walked.out[0], expected);
      expect_mean(walked.out[0], table, 1e-5);
    }
}

TEST(SlabAlbedo, ChannelsOfSkinAreEachRight) {
  const Rgb albedo(0.9f, 0.6f, 0.45f);
  const Medium medium = make_medium(albedo, {1.0f, 0.35f, 0.2f}, AlbedoInversion::exact);
  const BodyStatistics walked = walk_many(kHalfSpace, medium, {}, 150000, 21);
  for (int c = 0; c < 3; ++c) expect_mean(walked.out[c], albedo[c]);
  EXPECT_LE(walked.counters.max_walk_weight, 3 * (1 + 1e-9));
}

// Chooses by throughput but divides by the pdf of a uniform choice.
class WronglyWeightedSegment {
 public:
  WronglyWeightedSegment(const WalkMedium& medium, const ChannelValues& throughput)
      : sampled_(medium, throughput), wrong_(medium, {1, 1, 1}), throughput_(throughput) {}
  float sample_distance(const Vec2f& u) const { return sampled_.sample_distance(u); }
  ChannelValues scatter_throughput(double t) const { return scale(wrong_.scatter_throughput(t)); }
  ChannelValues exit_throughput(double t) const { return scale(wrong_.exit_throughput(t)); }

 private:
  ChannelValues scale(ChannelValues v) const {
    for (size_t c = 0; c < 3; ++c) v[c] *= throughput_[c];
    return v;
  }
  ChromaticSegment sampled_, wrong_;
  ChannelValues throughput_;
};

TEST(SlabAlbedo, AWrongPdfIsNoticed) {
  const Rgb albedo(0.9f, 0.6f, 0.45f);
  const Medium medium = make_medium(albedo, {1.0f, 0.35f, 0.2f}, AlbedoInversion::exact);
  WalkSettings settings;
  settings.safety_cap = 1000;  // wrong weights may let a walk go on forever
  const BodyStatistics walked = walk_many<WronglyWeightedSegment>(kHalfSpace, medium, settings, 20000, 30);
  int failures = 0;
  for (int c = 0; c < 3; ++c) failures += noticed(z_test(walked.out[c], albedo[c])) ? 1 : 0;
  EXPECT_GT(failures, 0);
}

TEST(SlabAlbedo, ASlightlyWrongAlbedoIsNoticed) {
  // The paper's eq. 1 at A = 0.8 is off by half a per cent, which the test above must be able to detect.
  const Medium medium = make_medium(Rgb(0.8f), {1.0f, 0, 0}, AlbedoInversion::chiang2016);
  const BodyStatistics walked = walk_many(kHalfSpace, medium, {}, 500000, 31);
  EXPECT_TRUE(noticed(z_test(walked.out[0], 0.8)));
}

TEST(SlabAlbedo, NearWhiteNeedsNoCap) {
  const Medium medium = make_medium(Rgb(0.99f), {1.0f, 0, 0}, AlbedoInversion::exact);
  const BodyStatistics walked = walk_many(kHalfSpace, medium, {}, 20000, 32);
  expect_mean(walked.out[0], static_cast<double>(0.99f));
}

TEST(ThinSlab, ReflectsAndTransmitsWhatTheIntegralEquationSays) {
  struct Row {
    double albedo, thickness, reflectance, transmittance;  // measured independently, +- 3e-4
  };
  constexpr Row kRows[] = {
      {0.5, 1, .3625, .4822}, {0.5, 4, .4937, .0992}, {0.9, 1, .4443, .5515}, {0.9, 4, .7446, .2391}};
  uint64_t seed = 40;
  for (const Row& row : kRows) {
    SCOPED_TRACE(row.albedo * 100 + row.thickness);
    const double complement = one_minus_alpha(row.albedo, AlbedoInversion::exact);
    const SlabAnswer answer = solve_slab(row.thickness, complement);
    EXPECT_NEAR(answer.reflectance, row.reflectance, 6e-4);
    EXPECT_NEAR(answer.transmittance, row.transmittance, 6e-4);
    const BodyStatistics walked =
        walk_many([&] { return SlabTracer(row.thickness); }, unit_medium(complement), {}, 100000, ++seed);
    expect_mean(walked.through, answer.transmittance, answer.error);
    expect_mean(walked.out[0], answer.reflectance + answer.transmittance, 2 * answer.error);
    expect_mean(walked.uncollided, slab_zero_scatter(row.thickness));
  }
}

TEST(ThinSlab, LosesNothingWithoutAbsorption) {
  const Medium medium = make_medium(Rgb(1.0f), {1.0f, 0.3f, 4.0f}, AlbedoInversion::exact);
  const BodyStatistics walked = walk_many([] { return SlabTracer(2); }, medium, {}, 40000, 50);
  // White in every channel: each walk's throughputs add up to three at every exit.
  for (const RunningStatistics& channel : walked.out) expect_mean(channel, 1);
  double total = 0;
  for (const RunningStatistics& channel : walked.out) total += channel.mean();
  EXPECT_NEAR(total, 3, 1e-9);
}

TEST(ClosedSphere, CrossesWithoutCollisionAsTheFormulaSays) {
  uint64_t seed = 60;
  for (const double radius : {0.1, 1.0, 3.0}) {
    const BodyStatistics walked = walk_many([&] { return SphereTracer(radius); }, unit_medium(0.5), {}, 100000, ++seed);
    expect_mean(walked.uncollided, sphere_zero_scatter(radius));
  }
}

TEST(ClosedSphere, FurnaceAlbedoIsTheIntegralEquations) {
  constexpr double kRadii[] = {0.1, 1, 3};
  constexpr double kAlbedos[] = {0.2, 0.5, 0.8, 0.95};
  constexpr double kMeasured[3][4] = {{.949, .988, .999, 1.000}, {.617, .891, .988, .999}, {.342, .735, .964, .998}};
  uint64_t seed = 70;
  for (size_t r = 0; r < 3; ++r)
    for (size_t a = 0; a < 4; ++a) {
      const double complement = one_minus_alpha(kAlbedos[a], AlbedoInversion::exact);
      const SphereAnswer answer = solve_sphere(kRadii[r], complement);
      EXPECT_NEAR(answer.albedo, kMeasured[r][a], 1.1e-3);
      const BodyStatistics walked =
          walk_many([&] { return SphereTracer(kRadii[r]); }, unit_medium(complement), {}, 40000, ++seed);
      SCOPED_TRACE(kRadii[r] * 100 + kAlbedos[a]);
      expect_mean(walked.out[0], answer.albedo, answer.error);
    }
}

TEST(ClosedSphere, MeanPathIsFourVolumesOverSurface) {
  // Blanco and Fournier 2003: without absorption the mean path is the same for any mean free path; here 4/3 radius.
  uint64_t seed = 90;
  for (const double radius : {0.1, 1.0, 10.0}) {
    Rng rng(run_seed(++seed), 77);
    RenderCounters counters;
    RunningStatistics lengths, collisions;
    for (int i = 0; i < run_samples(40000); ++i) {
      SphereTracer tracer(radius);
      const auto end = walk_body(tracer, unit_medium(0), {}, rng, counters);
      ASSERT_TRUE(end);
      EXPECT_NEAR(end->throughput[0], 1, 1e-9);
      lengths.add(tracer.path_length());
      collisions.add(end->events);
    }
    expect_mean(lengths, 4.0 / 3 * radius);
    expect_mean(collisions, 4.0 / 3 * radius);
  }
}

TEST(ClosedSphere, ChannelsMatchGreyRunsAtExtremeDistanceRatios) {
  // Distances four decades apart, and a dark channel with the long one: w ~ T stays bounded and right.
  const double radius = 0.05;
  const Rgb albedo(0.9f, 0.5f, 0.2f), distance(0.01f, 1.0f, 100.0f);
  const Medium medium = make_medium(albedo, distance, AlbedoInversion::exact);
  const BodyStatistics walked = walk_many([&] { return SphereTracer(radius); }, medium, {}, 100000, 100);
  for (int c = 0; c < 3; ++c) {
    const double complement = one_minus_alpha(albedo[c], AlbedoInversion::exact);
    const SphereAnswer answer = solve_sphere(radius * medium.sigma_t[c], complement);
    expect_mean(walked.out[c], answer.albedo, answer.error);
  }
  EXPECT_LE(walked.counters.max_walk_weight, 3 * (1 + 1e-9));
}

}  // namespace
}  // namespace alabaster::testing
