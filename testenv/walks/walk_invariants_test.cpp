// Invariants of the throughput in chromatic distance sampling, for every medium, however extreme.
#include <gtest/gtest.h>

#include "testenv/support/analytic_bodies.h"

namespace alabaster {
namespace {

using testing::SlabTracer;
using testing::SphereTracer;
using testing::walk_body;

double sum(const ChannelValues& v) {
  return v[0] + v[1] + v[2];
}

double log_uniform(Rng& rng, double decades) {
  return std::pow(10.0, decades * (2 * static_cast<double>(rng.uniform()) - 1));
}

double random_complement(Rng& rng) {
  switch (rng.next() % 6) {
    case 0:
      return 0;  // white
    case 1:
      return 1;  // black
    case 2:
      return 1e-9 * static_cast<double>(rng.uniform());
    case 3:
      return 1 - 1e-6 * static_cast<double>(rng.uniform());
    default:
      return rng.uniform();
  }
}

/// Mean free paths up to twelve decades apart; albedos from black to white; sometimes a channel that does not scatter.
Medium random_medium(Rng& rng) {
  Medium medium;
  const double decades = 6 * static_cast<double>(rng.uniform());
  for (int c = 0; c < 3; ++c) {
    const double complement = random_complement(rng);
    medium.active[c] = rng.uniform() < 0.9f;
    if (!medium.active[c]) continue;
    medium.sigma_t[c] = static_cast<float>(log_uniform(rng, decades));
    medium.alpha[c] = static_cast<float>(1 - complement);
    medium.one_minus_alpha[c] = static_cast<float>(complement);
  }
  return medium;
}

ChannelValues random_throughput(Rng& rng, const Medium& medium) {
  ChannelValues t{};
  for (size_t c = 0; c < 3; ++c)
    if (medium.active[c]) t[c] = std::min(1.0, log_uniform(rng, 4));
  return t;
}

constexpr double kRounding = 1 + 1e-12;

/// `check(walk_medium, before, segment, t)` for many media, throughputs and distances that can be drawn.
template <class Check>
void for_random_segments(uint64_t seed, const Check& check) {
  Rng rng(seed, 1);
  for (int i = 0; i < 50000; ++i) {
    const Medium medium = random_medium(rng);
    const WalkMedium walk_medium(medium);
    const ChannelValues before = random_throughput(rng, medium);
    if (!(max_value(before) > 0)) continue;
    const ChromaticSegment segment(walk_medium, before);
    const float t = segment.sample_distance({rng.uniform(), rng.uniform()});
    if (t < std::numeric_limits<float>::infinity()) check(walk_medium, before, segment, static_cast<double>(t));
  }
}

TEST(WalkInvariants, ThroughputWeightsNeverRaiseAnyChannelAboveTheSum) {
  const auto check = [](const WalkMedium& medium, const ChannelValues& before, const ChromaticSegment& segment,
                        double t) {
    const ChannelValues scattered = segment.scatter_throughput(t);
    for (size_t c = 0; c < 3; ++c) EXPECT_LE(scattered[c], medium.alpha[c] * sum(before) * kRounding);
    for (const double part : {1.0, 0.5, 1e-3})
      EXPECT_NEAR(sum(segment.exit_throughput(part * t)) / sum(before), 1, 1e-12);  // an exit keeps the sum
  };
  for_random_segments(2, check);
}

/// Largest throughput at any event or exit of walks in thin and thick bodies.
double largest_weight(const Medium& medium, Rng& rng) {
  WalkSettings settings;
  settings.safety_cap = 2000;  // white and thick: such walks may be endless
  RenderCounters counters;
  for (int i = 0; i < 40; ++i) {
    SphereTracer sphere(1);
    walk_body(sphere, medium, settings, rng, counters);
    SlabTracer slab(0.05);
    walk_body(slab, medium, settings, rng, counters);
  }
  return counters.max_walk_weight;
}

TEST(WalkInvariants, WholeWalksStayBelowThree) {
  Rng rng(3, 1);
  double largest = 0;
  for (int i = 0; i < 1000; ++i) {
    const double weight = largest_weight(random_medium(rng), rng);
    EXPECT_LE(weight, 3 * kRounding);
    largest = std::max(largest, weight);
  }
  EXPECT_GT(largest, 2.5);  // and the bound is the best there is
}

}  // namespace
}  // namespace alabaster
