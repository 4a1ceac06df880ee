// Runs many walks, with the same result for any number of threads. Walks come in chunks, each with a random stream of
// its own, and the chunks are added up in order.
#pragma once

#include <tbb/parallel_for.h>

#include <vector>

#include "testenv/support/analytic_bodies.h"
#include "testenv/support/z_test.h"

namespace alabaster::testing {

/// `walk(rng, totals)` runs one walk and adds to its chunk's `Totals`, which has merge().
template <class Totals, class Walk>
Totals run_chunks(uint64_t count, uint32_t seed, const Walk& walk) {
  constexpr uint64_t kChunk = 1024;
  std::vector<Totals> parts((count + kChunk - 1) / kChunk);
  tbb::parallel_for(size_t(0), parts.size(), [&](size_t chunk) {
    const PixelSampler sampler(pixel_seed(static_cast<int>(chunk), 0, 0, seed), 0);
    Rng rng = sampler.stream(Dimension::subsurface, 0);
    for (uint64_t i = chunk * kChunk; i < std::min(count, (chunk + 1) * kChunk); ++i) walk(rng, parts[chunk]);
  });
  Totals total;
  for (const Totals& part : parts) total.merge(part);
  return total;
}

struct WalkTotals {
  RunningStatistics out[3];      // throughput per channel of all exits
  RunningStatistics back;        // channel 0 of exits on side 0
  RunningStatistics through;     // channel 0 of exits on side 1
  RunningStatistics uncollided;  // channel 0 of exits without a scattering event
  RunningStatistics events;
  RenderCounters counters;

  void add(const WalkLoopExit<BodyHit>* end, double events_of_walk) {
    for (size_t c = 0; c < 3; ++c) out[c].add(end ? end->throughput[c] : 0);
    back.add(end && end->hit.side == 0 ? end->throughput[0] : 0);
    through.add(end && end->hit.side == 1 ? end->throughput[0] : 0);
    uncollided.add(end && end->events == 0 ? end->throughput[0] : 0);
    events.add(events_of_walk);
  }
  void merge(const WalkTotals& o) {
    for (size_t c = 0; c < 3; ++c) out[c].merge(o.out[c]);
    back.merge(o.back);
    through.merge(o.through);
    uncollided.merge(o.uncollided);
    events.merge(o.events);
    counters.add(o.counters);
  }
};

/// The walk without shortcuts, as in the paper.
inline WalkSettings plain_walk() {
  WalkSettings settings;
  settings.guiding = settings.sphere_steps = false;
  return settings;
}

/// Walks in a body of analytic_bodies.h, with the shortcuts of the settings; `make_tracer()` puts a tracer at the entry
/// point.
template <class MakeTracer>
WalkTotals walk_bodies(const MakeTracer& make_tracer, const Medium& medium, const WalkSettings& settings,
                       uint64_t count, uint32_t seed) {
  return run_chunks<WalkTotals>(count, seed, [&](Rng& rng, WalkTotals& totals) {
    auto tracer = make_tracer();
    const uint64_t before = totals.counters.walk_events;
    const auto end = walk_body_with_shortcuts(tracer, medium, settings, rng, totals.counters);
    totals.add(end ? &*end : nullptr, static_cast<double>(totals.counters.walk_events - before));
  });
}

}  // namespace alabaster::testing
