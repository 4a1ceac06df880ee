#include <tbb/task_arena.h>

#include <algorithm>
#include <bit>
#include <new>
#include <optional>
#include <thread>

#include "core/session/deferred_notifier.h"
#include "core/session/running_render.h"
#include "core/session/worker_threads.h"

namespace alabaster {
namespace {

struct TileRelease {
  std::atomic<uint32_t>& passes;
  uint32_t pass;
  ~TileRelease() {
    passes.store(pass + 1);
    passes.notify_all();
  }
};

}  // namespace

// `grace`: seconds after the limit in which samples may still be taken.
bool RenderSession::Render::time_is_over(double grace) {
  if (!(time_limit > 0) || seconds_since(started.load()) < time_limit + grace) return false;
  out_of_time = true;
  return true;
}

// True: the caller is to measure the noise so far, once the tile is free.
bool RenderSession::Render::tile_done(uint32_t pass, bool done, const RenderCounters& counters, double cpu_seconds) {
  const std::lock_guard lock(mutex);
  progress.counters.add(counters);
  progress.samples_done = progress.counters.samples;
  progress.cpu_seconds += cpu_seconds;
  if (!done) return false;
  const uint32_t finished_before = finished.count();
  finished.add_tile(pass);
  progress.passes_done = passes_before + count_whole_passes(schedule, finished.count());
  return finished.count() > finished_before && takes_noise();
}

// Under the mutex, at the end of a pass. The end of a round measures the noise anyway.
bool RenderSession::Render::takes_noise() {
  constexpr uint32_t kLeastPasses = 2;  // with less than two samples in a pixel no noise is known
  if (!noise_asked || progress.passes_done < kLeastPasses || finished.count() == schedule.size()) return false;
  if (request.settings.target_error > 0 || SessionClock::now() < next_noise) return false;
  noise_asked = false;
  next_noise = SessionClock::time_point::max();  // one at a time
  return true;
}

// In the thread of one worker, while the others render on. Without memory the noise stays unknown: the frame needs
// none.
void RenderSession::Render::measure_so_far() {
  constexpr int kRest = 20;  // times as long as a measurement took, until the next one, of whichever frame
  const SessionClock::time_point begun = SessionClock::now();
  uint64_t samples = 0;
  {
    const std::lock_guard lock(mutex);
    samples = progress.samples_done;
  }
  std::optional<FrameError> error;
  try {
    const CancelToken cancel(&stop_requested);
    tbb::task_arena(1).execute([&] { error = estimate_frame_error(film_noise(*film, cancel), cancel); });
  } catch (const BuildCancelled&) {
  } catch (const std::bad_alloc&) {
  }
  const std::lock_guard lock(mutex);
  const SessionClock::time_point now = SessionClock::now();
  next_noise = now + kRest * (now - begun);
  if (!error) return;
  progress.noise = *error;
  progress.noise_samples = samples;
}

// Work items are (pass, tile) in order. Passes overlap, so that no worker idles at the end of one. The passes of one
// tile do not: its sums are taken in sample order, by whichever worker.
void RenderSession::Render::render_items(const TileRenderer& renderer) {
  const size_t items = tile_order->size() * schedule.size();
  for (size_t item; (item = next_item.fetch_add(1)) < items;) {
    bool noise_is_due = false;
    if (!render_item(renderer, item, &noise_is_due)) return;
    if (noise_is_due) measure_so_far();
  }
}

// False: the worker ends.
bool RenderSession::Render::render_item(const TileRenderer& renderer, size_t item, bool* noise_is_due) {
  // Wait until the tile's pass before it is done.
  const int tile = (*tile_order)[item % tile_order->size()];
  const auto pass = static_cast<uint32_t>(item / tile_order->size());
  std::atomic<uint32_t>& passes = tile_passes[static_cast<size_t>(tile)];
  for (uint32_t done; (done = passes.load()) != pass && !stop_requested;) passes.wait(done);

  // Render it. An exception releases the tile, too: no worker may wait for a tile that no other renders.
  const double cpu = cpu_seconds(CLOCK_THREAD_CPUTIME_ID);
  RenderCounters counters;
  const TileRelease release{passes, pass};
  bool done = false;
  try {
    done = !stop_requested && render_tile(renderer, schedule[pass], tile, &counters);
  } catch (...) {
    stop_requested = cancelled = true;  // before the tile is released: the other workers end, too
    throw;
  }

  // Report it.
  *noise_is_due = tile_done(pass, done, counters, cpu_seconds(CLOCK_THREAD_CPUTIME_ID) - cpu);
  return done;
}

bool RenderSession::Render::render_tile(const TileRenderer& renderer, const SamplePass& pass, int tile,
                                        RenderCounters* counters) {
  const DeferredNotifier::Poller poller(notifier);
  const auto may_go_on = [&] {
    poller.poll();
    if (yields_core_to_builder && notifier->wants_core()) [[unlikely]]
      notifier->yield_core(stop_requested);
    return wait_while_paused() && !time_is_over(pass.end == 1 ? kFirstSampleGrace : 0);
  };
  const TileSamples samples{film->tile_rect(tile), pass, allocation, stopping.groups_to_trace()};
  FilmWriter pixels(film.get(), tile);
  return renderer.render(samples, may_go_on, &pixels, counters);
}

// Renders one round.
void RenderSession::Render::run_workers(const TileRenderer& renderer, const SampleRange& round, int threads) {
  yields_core_to_builder = notifier && threads > 1 && threads >= static_cast<int>(std::thread::hardware_concurrency());
  next_item = 0;
  tile_passes = std::vector<std::atomic<uint32_t>>(tile_order->size());
  {
    const std::lock_guard lock(mutex);
    noise_is_known = false;
    schedule = make_pass_schedule(round);
    passes_before = progress.passes_done;
    finished = FinishedPasses(tile_passes.size(), schedule.size());
  }
  run_on_threads(threads, [&] { render_items(renderer); });
}

// False: a stop or the time limit has come before the first sample.
bool RenderSession::Render::prepare(std::optional<TileRenderer>* renderer) {
  try {
    renderer->emplace(request, CancelToken(&cancelled));
    return true;
  } catch (const BuildCancelled&) {
    return false;
  }
}

// Cancels preparation and walks, which do not check the clock, once the time limit has passed. If no thread can be
// started for it, they run to their end.
std::jthread RenderSession::Render::watch_time() {
  if (!(time_limit > 0)) return {};
  const auto left = [this] {
    const std::lock_guard lock(mutex);
    return time_limit + kFirstSampleGrace - seconds_rendered();
  };
  try {
    return std::jthread([this, left](const std::stop_token& render_ended) {
      constexpr double kLook = 0.02;  // seconds between looks while a pause stops the clock
      std::mutex own;
      std::unique_lock lock(own);
      std::condition_variable_any never;
      for (double seconds; (seconds = left()) > 0 && !render_ended.stop_requested();)
        never.wait_for(lock, render_ended, std::chrono::duration<double>(std::max(seconds, kLook)),
                       [] { return false; });
      if (!render_ended.stop_requested()) out_of_time = cancelled = true;
    });
  } catch (const std::exception&) {
    return {};
  }
}

// A frame is rendered in rounds. All decisions fall between rounds, when every tile stands at the same sample, so they
// do not depend on threads. The caller is in an arena of `threads`.
void RenderSession::Render::run_rounds(int threads) {
  const RenderSettings& settings = request.settings;
  const bool has_target = settings.target_error > 0;
  const bool adaptive = is_adaptive(settings);
  std::jthread watch = watch_time();
  std::optional<TileRenderer> renderer;
  if (!prepare(&renderer)) return end_rounds(false);

  // Where decisions follow, the first round is a pilot; else it is the rest of the frame.
  const bool decides = has_target || adaptive;
  if (!decides || round.end == 0) {
    const std::lock_guard still(decisions);
    round = {film->extras().range.begin + film->least_samples(),
             decides ? std::min(settings.samples, kPilotSamples) : settings.samples};
  }
  while (round.begin < round.end && !stopping.all_ended()) {
    // Trace the round's samples and measure the error that is left.
    run_workers(*renderer, round, threads);
    if (stop_requested) break;
    const NoiseImage noise = measure_noise(round.end);
    if (stop_requested || out_of_time) break;

    // After the pilot, send the samples to where they help most.
    const std::lock_guard still(decisions);
    if (adaptive && round.begin == 0)
      allocation = SampleAllocation(*film, film->rays(), has_target ? 0 : settings.samples);

    // End the groups of pixels that have reached the target.
    if (has_target) end_groups(noise);

    // Go on to the next check of the error, or to the end.
    round = {round.end, has_target ? std::min(settings.samples, next_error_check(round.end)) : settings.samples};
  }
  watch = {};
  // A round after the last is left where the target ended a render, also one that is shown or continued again.
  end_rounds(has_target && (stopping.all_ended() || round.end < settings.samples));
}

void RenderSession::Render::end_groups(const NoiseImage& noise) {
  stopping.update(*film, noise, request.settings.target_error);
  const std::lock_guard lock(mutex);
  if (progress.noise.relative_rmse > 0) progress.groups_over_frame = stopping.error() / progress.noise.relative_rmse;
}

void RenderSession::Render::end_rounds(bool reached_target) {
  {
    const std::lock_guard lock(mutex);
    progress.ended_by = stop_requested   ? RenderEnd::none
                        : out_of_time    ? RenderEnd::time_limit
                        : reached_target ? RenderEnd::target_error
                                         : RenderEnd::samples;
  }
  show_ended_groups();
}

// Groups that ended before others show what they had then. Nothing is left to decide, unless a stop or the time limit
// has cut the render short: then save() still writes the pixels that were traced on.
void RenderSession::Render::show_ended_groups() {
  const std::lock_guard still(decisions);
  if (!stopping.show_ended(film.get())) return;
  cut_short = stop_requested || out_of_time;
  if (!cut_short) stopping = {}, round.begin = round.end;
  const std::lock_guard lock(mutex);
  noise_is_known = false;
}

// Measures what the film has, and reports its error. Where a target decides, the error also predicts how many samples
// the frame will take. A stop cancels it: then what it returns is not to be used.
NoiseImage RenderSession::Render::measure_noise(uint32_t samples) {
  NoiseImage noise;
  FrameError error;
  constexpr uint32_t kLeast = 2;  // samples without which no noise is known: a large frame is not read in vain
  if (out_of_time && film->least_samples() < kLeast) return noise;
  try {
    const CancelToken cancel(&stop_requested);
    noise = film_noise(*film, cancel);
    error = estimate_frame_error(noise, cancel);
  } catch (const BuildCancelled&) {
    return noise;
  }
  const RenderSettings& settings = request.settings;
  const std::lock_guard lock(mutex);
  if (stop_requested) return noise;
  progress.noise = error;
  progress.noise_samples = progress.samples_done;
  noise_is_known = true;
  if (settings.target_error > 0 && error.known) {
    // Groups that have ended take no more.
    const auto groups = static_cast<uint64_t>(kPixelGroups - std::popcount(stopping.ended()));
    const uint32_t needed = samples_for_error(samples, settings.samples, error.relative_rmse, settings.target_error);
    progress.samples_total =
        progress.samples_done + progress.pixels * groups / kPixelGroups * (std::max(needed, samples) - samples);
  }
  return noise;
}

}  // namespace alabaster
