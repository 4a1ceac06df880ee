// Prints, as Markdown, what albedo each inversion obtains through the renderer's walk in a half-space, and what that
// costs. Runs for minutes: not a test.
//   subsurface_tables [--paths N]
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "testenv/support/albedo_table.h"
#include "testenv/support/analytic_bodies.h"

namespace alabaster::testing {
namespace {

struct Measured {
  double albedo = 0, sigma = 0, events = 0;
  uint64_t capped = 0;
};

Measured measure(double complement, long paths, uint64_t seed) {
  Rng rng(seed, 5);
  RenderCounters counters;
  double out = 0;
  const Medium medium = unit_medium(complement);
  for (long i = 0; i < paths; ++i) {
    SlabTracer tracer;
    const auto end = walk_body(tracer, SlabTracer::entry(), medium, {}, rng, counters);
    if (end) out += end->throughput[0];
  }
  // A grey walk comes out with weight one or not at all.
  const double n = static_cast<double>(paths), mean = out / n;
  return {mean, std::sqrt(mean * (1 - mean) / n), static_cast<double>(counters.walk_events) / n,
          counters.walk_safety_cap};
}

void print_inversion_table(long paths) {
  constexpr AlbedoInversion kInversions[] = {AlbedoInversion::chiang2016, AlbedoInversion::exact,
                                             AlbedoInversion::van_de_hulst};
  std::printf("%ld walks per entry; 'obtained' is walked +- one standard error, then what the H function says.\n\n",
              paths);
  std::printf("| A asked | chiang2016: walked | H | exact: walked | H | van_de_hulst: walked | H |");
  std::printf(" events chiang2016 / exact |\n|--|--|--|--|--|--|--|--|\n");
  uint64_t seed = 0, capped = 0;
  for (const AlbedoRow& row : kAlbedoTable) {
    std::printf("| %g |", row.albedo);
    double events[3] = {};
    for (size_t i = 0; i < 3; ++i) {
      const double complement = one_minus_alpha(row.albedo, kInversions[i]);
      const Measured measured = measure(complement, paths, ++seed);
      std::printf(" %.5f +- %.5f | %.6f |", measured.albedo, measured.sigma, half_space_albedo(complement));
      events[i] = measured.events;
      capped += measured.capped;
    }
    std::printf(" %.2f / %.2f |\n", events[0], events[1]);
    std::fflush(stdout);
  }
  std::printf("\nWalks cut off by the safety cap of 1e6 events (white half-spaces only): %llu.\n",
              static_cast<unsigned long long>(capped));
}

// Relative variance and cost of the two weight schemes on skin.
void print_weights_table(long paths) {
  const Rgb albedo(0.9f, 0.6f, 0.45f);
  const Medium medium = make_medium(albedo, {1.0f, 0.35f, 0.2f}, AlbedoInversion::exact);
  std::printf("\nSkin, A = (.9, .6, .45), d = (1, .35, .2), exact inversion:\n\n");
  std::printf("| weights | A red | green | blue | relative variance | events | largest weight |\n");
  std::printf("|--|--|--|--|--|--|--|\n");
  for (const WalkWeights weights : {WalkWeights::throughput, WalkWeights::throughput_times_albedo}) {
    WalkSettings settings;
    settings.weights = weights;
    Rng rng(99, 5);
    RenderCounters counters;
    ChannelValues sum{}, squares{};
    for (long i = 0; i < paths; ++i) {
      SlabTracer tracer;
      const auto end = walk_body(tracer, SlabTracer::entry(), medium, settings, rng, counters);
      for (size_t c = 0; end && c < 3; ++c) {
        sum[c] += end->throughput[c];
        squares[c] += end->throughput[c] * end->throughput[c];
      }
    }
    const double n = static_cast<double>(paths);
    std::printf("| %s |", weights == WalkWeights::throughput ? "T" : "T alpha");
    double relative_variance = 0;
    for (size_t c = 0; c < 3; ++c) {
      const double mean = sum[c] / n, variance = squares[c] / n - mean * mean;
      relative_variance += variance / (mean * mean) / 3;
      std::printf(" %.5f +- %.5f |", mean, std::sqrt(variance / n));
    }
    std::printf(" %.3f | %.1f | %.2f |\n", relative_variance, static_cast<double>(counters.walk_events) / n,
                counters.max_walk_weight);
  }
}

}  // namespace
}  // namespace alabaster::testing

int main(int argc, char** argv) {
  long paths = 200000;
  if (argc == 3 && std::strcmp(argv[1], "--paths") == 0) paths = std::strtol(argv[2], nullptr, 10);
  if (paths < 2 || (argc != 1 && argc != 3)) {
    std::fprintf(stderr, "usage: subsurface_tables [--paths N]   (N walks per entry, at least 2)\n");
    return 2;
  }
  alabaster::testing::print_inversion_table(paths);
  alabaster::testing::print_weights_table(paths);
  return 0;
}
