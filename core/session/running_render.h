// One render of a RenderSession: running_render.cpp begins, ends and reports it; running_render_workers.cpp renders.
#pragma once

#include <time.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "core/convergence/group_stopping.h"
#include "core/convergence/sample_allocation.h"
#include "core/session/frame_memory.h"
#include "core/session/pass_schedule.h"
#include "core/session/render_session.h"
#include "core/session/tile_renderer.h"

namespace alabaster {

using SessionClock = std::chrono::steady_clock;

inline double seconds_since(const SessionClock::time_point& start) {
  return std::chrono::duration<double>(SessionClock::now() - start).count();
}

inline double cpu_seconds(clockid_t clock) {
  timespec t{};
  clock_gettime(clock, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// Seconds after the time limit within which a pixel may get its first sample.
inline constexpr double kFirstSampleGrace = 0.5;

// One render from start to end.
struct RenderSession::Render {
  Render() = default;  // idle
  // Continues the checkpoint of the request, or `last` if its samples are the first of `next`; `last` has ended then.
  Render(const RenderRequest& next, Render* last, DeferredNotifier* notifier);

  RenderRequest request;                               // not changed after the constructor, like the two below
  DeferredNotifier* notifier = nullptr;                // that render threads poll; null: none
  std::shared_ptr<const std::vector<int>> tile_order;  // from the centre outwards

  mutable std::mutex mutex;  // guards the members down to next_noise; never held while rendering
  std::condition_variable changed;
  RenderProgress progress;
  std::shared_ptr<Film> film;                     // null: the render after this one has taken its memory
  bool noise_is_known = false;                    // progress.noise is the film's
  std::atomic<SessionClock::time_point> started;  // later by the pauses that are over
  SessionClock::time_point paused;                // the pause that goes on
  PassSchedule schedule;                          // of the current round
  FinishedPasses finished{0, 0};
  uint32_t passes_before = 0;                // in earlier rounds
  std::shared_ptr<const Denoiser> denoiser;  // null: none is asked for, or the film is denoised

  SessionClock::time_point next_noise;  // not measured before, while workers render

  std::atomic<bool> noise_asked{false};
  std::atomic<bool> stop_requested{false};
  std::atomic<bool> out_of_time{false};
  std::atomic<bool> cancelled{false};        // with a stop, and soon after the time limit: of walks and what precedes
  double time_limit = 0;                     // seconds; 0: none
  std::atomic<bool> pause_requested{false};  // changed under the mutex
  std::mutex stopped_denoise;                // one caller denoises a stopped film, and the others wait for it

  // Changed by the driver between rounds only, under a mutex that save() holds while it writes.
  std::mutex decisions;
  SampleRange round;
  bool cut_short = false;  // the film shows groups as they ended though others have not, so no render takes it over
  SampleAllocation allocation;
  GroupStopping stopping;

  // Work of the current round.
  std::atomic<size_t> next_item{0};
  std::vector<std::atomic<uint32_t>> tile_passes;  // passes that each tile has finished
  bool yields_core_to_builder = false;             // one of the workers does

  void render();
  void request_stop();
  void mark_dropped();
  void take_film_memory(Render* last);
  bool wait(double seconds);
  RenderProgress report();
  bool save(const BlockSink& sink);
  RenderProgress continue_checkpoint(RenderState* from);
  RenderProgress continue_render(const Render& last);
  void show_begin(const RenderProgress& before);
  void run_rounds(int threads);
  void end_groups(const NoiseImage& noise);
  void end_rounds(bool reached_target);
  std::jthread watch_time();
  bool prepare(std::optional<TileRenderer>* renderer);
  bool can_be_continued_by(const RenderRequest& next) const;
  void show_ended_groups();
  void run_workers(const TileRenderer& renderer, const SampleRange& round, int threads);
  void render_items(const TileRenderer& renderer);
  bool render_item(const TileRenderer& renderer, size_t item, bool* noise_is_due);
  bool render_tile(const TileRenderer& renderer, const SamplePass& pass, int tile, RenderCounters* counters);
  void set_paused(bool pause);
  bool wait_while_paused();
  bool time_is_over(double grace);
  double seconds_rendered() const;
  bool tile_done(uint32_t pass, bool done, const RenderCounters& counters, double cpu_seconds);
  bool takes_noise();
  void measure_so_far();
  NoiseImage measure_noise(uint32_t samples);
  void denoise(const Film* stopped);
  void measure_stopped();
};

}  // namespace alabaster
