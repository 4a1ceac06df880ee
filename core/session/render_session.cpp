#include "core/session/render_session.h"

#include <ctime>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "core/convergence/group_stopping.h"
#include "core/convergence/sample_allocation.h"
#include "core/denoise/denoise_film.h"
#include "core/session/pass_schedule.h"

namespace alabaster {
namespace {

using Clock = std::chrono::steady_clock;

// Samples per pixel before which no time limit ends a render.
constexpr uint32_t kLeastSamples = 2;

double seconds_since(const Clock::time_point& start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

double cpu_seconds(clockid_t clock) {
  timespec t{};
  clock_gettime(clock, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

// Memory may have run out, and then a report must need none: the short text fits into the string itself.
std::string failure_text(const char* what) noexcept {
  try {
    return std::string("rendering failed: ") + what;
  } catch (...) {
    return "out of memory";
  }
}

struct TileRelease {
  std::atomic<uint32_t>& passes;
  uint32_t pass;
  ~TileRelease() {
    passes.store(pass + 1);
    passes.notify_all();
  }
};

}  // namespace

// One render from start to end. The session holds the current one; a stopped one is joined before it is replaced.
struct RenderSession::State {
  mutable std::mutex mutex;  // guards the members down to denoise_threads; never held while rendering
  std::condition_variable changed;
  RenderProgress progress;
  std::shared_ptr<Film> film;
  Clock::time_point started;
  FinishedPasses finished{0, 0};             // of the current round
  uint32_t passes_before = 0;                // in earlier rounds
  std::shared_ptr<const Denoiser> denoiser;  // null: none is asked for, or the film is denoised
  uint32_t denoise_threads = 0;

  std::atomic<bool> stop_requested{false};
  std::atomic<bool> out_of_time{false};
  double time_limit = 0;                     // seconds; 0: none
  std::atomic<bool> pause_requested{false};  // changed under the mutex
  std::mutex stopped_denoise;                // one caller denoises a stopped film, and the others wait for it
  std::thread driver;

  // Changed between rounds only.
  SampleAllocation allocation;
  GroupStopping stopping;
  std::vector<uint32_t> pilot_rays;  // of each pixel, during an adaptive pilot; workers write their own tiles' pixels

  // Work of the current round.
  std::atomic<size_t> next_item{0};
  std::vector<std::atomic<uint32_t>> tile_passes;  // passes that each tile has finished

  void render(const RenderRequest& request);
  void run_rounds(const RenderRequest& request, int threads);
  void run_workers(const TileRenderer& renderer, const PassSchedule& schedule, int threads);
  void render_items(const TileRenderer& renderer, const PassSchedule& schedule);
  bool render_tile(const TileRenderer& renderer, const SampleRange& range, int tile, RenderCounters* counters);
  void set_paused(bool pause);
  bool wait_while_paused();
  bool time_is_over();
  void tile_done(uint32_t pass, const RenderCounters& counters, double cpu_seconds);
  void report_error(const RenderSettings& settings, uint32_t samples, const NoiseImage& noise);
  void denoise(const Film* stopped);
};

// False: stop.
bool RenderSession::State::wait_while_paused() {
  if (stop_requested.load(std::memory_order_relaxed)) return false;
  if (!pause_requested.load(std::memory_order_relaxed)) return true;
  std::unique_lock lock(mutex);
  changed.wait(lock, [this] { return !pause_requested || stop_requested; });
  return !stop_requested;
}

void RenderSession::State::set_paused(bool pause) {
  const std::lock_guard lock(mutex);
  if (progress.state != (pause ? SessionState::rendering : SessionState::paused)) return;
  pause_requested = pause;
  progress.state = pause ? SessionState::paused : SessionState::rendering;
  changed.notify_all();
}

bool RenderSession::State::time_is_over() {
  if (!(time_limit > 0)) return false;
  if (!out_of_time.load(std::memory_order_relaxed) && seconds_since(started) >= time_limit) out_of_time = true;
  return out_of_time.load(std::memory_order_relaxed);
}

void RenderSession::State::tile_done(uint32_t pass, const RenderCounters& counters, double cpu_seconds) {
  const std::lock_guard lock(mutex);
  progress.counters.add(counters);
  progress.samples_done = progress.counters.samples;
  progress.cpu_seconds += cpu_seconds;
  finished.add_tile(pass);
  progress.passes_done = passes_before + finished.count();
}

// Work items are (pass, tile) in order. Passes overlap, so that no worker idles at the end of one. The passes of one
// tile do not: its sums are taken in sample order, by whichever worker.
void RenderSession::State::render_items(const TileRenderer& renderer, const PassSchedule& schedule) {
  const auto tiles = static_cast<size_t>(film->tile_count());
  const size_t items = tiles * schedule.size();
  while (true) {
    // Take the next item, and wait until the tile's pass before it is done.
    const size_t item = next_item.fetch_add(1);
    if (item >= items) return;
    const size_t tile = item % tiles;
    const auto pass = static_cast<uint32_t>(item / tiles);
    for (uint32_t done; (done = tile_passes[tile].load()) != pass && !stop_requested;) tile_passes[tile].wait(done);

    // Render it. The tile is released also when an exception passes: nobody may wait for a tile that nobody works on.
    const double cpu = cpu_seconds(CLOCK_THREAD_CPUTIME_ID);
    RenderCounters counters;
    const TileRelease release{tile_passes[tile], pass};
    try {
      if (stop_requested || !render_tile(renderer, schedule[pass], static_cast<int>(tile), &counters)) return;
    } catch (...) {
      stop_requested = true;  // before the tile is released: the other workers end, too
      throw;
    }

    // Report it.
    tile_done(pass, counters, cpu_seconds(CLOCK_THREAD_CPUTIME_ID) - cpu);
  }
}

bool RenderSession::State::render_tile(const TileRenderer& renderer, const SampleRange& range, int tile,
                                       RenderCounters* counters) {
  const auto may_go_on = [&] { return wait_while_paused() && (range.begin < kLeastSamples || !time_is_over()); };
  FilmTile pixels = film->load_tile(tile);
  const TileSamples samples{film->tile_rect(tile), range, allocation, stopping.groups_to_trace(),
                            pilot_rays.empty() ? nullptr : &pilot_rays};
  if (!renderer.render(samples, may_go_on, &pixels, counters)) return false;
  film->store_tile(tile, pixels);
  return true;
}

// Renders one round on all threads of the caller's arena.
void RenderSession::State::run_workers(const TileRenderer& renderer, const PassSchedule& schedule, int threads) {
  next_item = 0;
  tile_passes = std::vector<std::atomic<uint32_t>>(static_cast<size_t>(film->tile_count()));
  {
    const std::lock_guard lock(mutex);
    passes_before = progress.passes_done;
    finished = FinishedPasses(tile_passes.size(), schedule.size());
  }
  tbb::parallel_for(
      0, threads, [&](int) { render_items(renderer, schedule); }, tbb::simple_partitioner());
}

// A frame is rendered in rounds. All decisions fall between rounds, when every tile stands at the same sample, so they
// do not depend on threads. The caller is in an arena of `threads`.
void RenderSession::State::run_rounds(const RenderRequest& request, int threads) {
  const RenderSettings& settings = request.settings;
  const bool has_target = settings.target_error > 0;
  const bool adaptive = settings.adaptive && settings.samples >= 2 * kPilotSamples;
  const TileRenderer renderer(request);
  if (adaptive) pilot_rays.resize(progress.pixels);

  // Where decisions follow, the first round is a pilot; else it is the whole frame.
  SampleRange round{0, has_target || adaptive ? std::min(settings.samples, kPilotSamples) : settings.samples};
  while (round.begin < round.end) {
    // Trace the round's samples and measure the error that is left.
    run_workers(renderer, make_pass_schedule(round), threads);
    const NoiseImage noise = film_noise(*film);
    report_error(settings, round.end, noise);
    if (stop_requested || out_of_time) break;

    // After the pilot, send the samples to where they help most.
    if (adaptive && round.begin == 0) {
      allocation = SampleAllocation(*film, pilot_rays, has_target ? 0 : settings.samples);
      pilot_rays = {};
    }

    // End the groups of pixels that have reached the target.
    if (has_target) {
      stopping.update(*film, noise, settings.target_error);
      if (stopping.all_ended()) break;
    }

    // Go on to the next check of the error, or to the end.
    round = {round.end, has_target ? std::min(settings.samples, next_error_check(round.end)) : settings.samples};
  }

  // Groups that ended before others show what they had then.
  if (stopping.restore_ended(film.get())) report_error(settings, round.end, film_noise(*film));
}

// Where a target decides, the error also predicts how many samples the frame will take.
void RenderSession::State::report_error(const RenderSettings& settings, uint32_t samples, const NoiseImage& noise) {
  const FrameError error = estimate_frame_error(noise);
  const std::lock_guard lock(mutex);
  progress.noise = error;
  if (settings.target_error > 0 && error.known)
    progress.samples_total =
        progress.pixels * samples_for_error(samples, settings.samples, error.relative_rmse, settings.target_error);
}

// Denoises the film of the render that the driver has just ended, or, unless null, `stopped` if it is still the last.
// Takes the denoiser, so that a film is denoised once; who is cancelled gives it back.
void RenderSession::State::denoise(const Film* stopped) {
  std::shared_ptr<const Denoiser> taken;
  std::shared_ptr<Film> shown;
  DenoiseOptions options;
  {
    const std::lock_guard lock(mutex);
    if (stopped && (film.get() != stopped || progress.state != SessionState::stopped)) return;
    taken.swap(denoiser);
    shown = film;
    options.threads = denoise_threads;
  }
  if (!taken) return;
  options.progress = [&](double fraction) {
    const std::lock_guard lock(mutex);
    if (film == shown) progress.denoised = fraction;
    return stopped || !stop_requested;
  };
  const Clock::time_point begun = Clock::now();
  const double cpu = cpu_seconds(CLOCK_PROCESS_CPUTIME_ID);
  std::string problem;
  const DenoiseStatus status = denoise_film(*taken, options, shown.get(), &problem);
  const std::lock_guard lock(mutex);
  if (film != shown) return;
  progress.denoise_seconds += seconds_since(begun);
  progress.denoise_cpu_seconds += cpu_seconds(CLOCK_PROCESS_CPUTIME_ID) - cpu;
  if (status == DenoiseStatus::cancelled) denoiser = taken;
  if (status == DenoiseStatus::done) progress.denoiser = taken->name();
  if (status == DenoiseStatus::failed) progress.denoise_error = problem;
}

void RenderSession::denoise_stopped(const Film* film) {
  const std::lock_guard one_at_a_time(state_->stopped_denoise);
  if (film) state_->denoise(film);
}

// Nothing may leave the driver thread: an exception there would end the host.
void RenderSession::State::render(const RenderRequest& request) {
  std::string error;
  std::optional<SampleAddress> failed_sample;
  try {
    // TBB prints a warning when an arena asks for more threads than the process may have, so never ask.
    const auto allowed = tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
    const uint32_t asked = request.settings.threads;
    tbb::task_arena arena(static_cast<int>(std::min<size_t>(asked > 0 ? asked : allowed, allowed)));
    arena.execute([&] { run_rounds(request, arena.max_concurrency()); });
    if (!stop_requested) denoise(nullptr);
  } catch (const SampleFailure& failure) {
    error = failure_text(failure.what());
    failed_sample = failure.at;
  } catch (const std::exception& e) {
    error = failure_text(e.what());
  } catch (...) {
    error = failure_text("unknown reason");
  }
  const std::lock_guard lock(mutex);
  progress.state = !error.empty()   ? SessionState::failed
                   : stop_requested ? SessionState::stopped
                                    : SessionState::finished;
  progress.error = std::move(error);
  progress.failed_sample = failed_sample;
  progress.wall_seconds = seconds_since(started);
  changed.notify_all();
}

RenderSession::RenderSession() : state_(std::make_unique<State>()) {}

RenderSession::~RenderSession() {
  stop();
}

void RenderSession::start(const RenderRequest& request) {
  stop();
  State& s = *state_;
  {
    const std::lock_guard lock(s.mutex);
    s.film = std::make_shared<Film>(request.data_window, with_guides(request.aovs));
    s.denoiser = request.aovs & aov_bit(Aov::denoised) ? request.denoiser : nullptr;
    s.denoise_threads = request.settings.threads;
    s.progress = {};
    s.progress.state = SessionState::rendering;
    s.progress.scene_number = request.scene->number;
    s.progress.pixels = static_cast<uint64_t>(std::max(0, request.data_window.width())) *
                        static_cast<uint64_t>(std::max(0, request.data_window.height()));
    s.progress.samples_total = s.progress.pixels * request.settings.samples;
    s.started = Clock::now();
    s.time_limit = std::max(0.0, static_cast<double>(request.settings.time_limit));
    s.pause_requested = false;
  }
  s.allocation = {};
  s.pilot_rays = {};
  s.stopping = {};
  s.stop_requested = false;
  s.out_of_time = false;
  RenderRequest guided = request;
  guided.aovs = with_guides(request.aovs);
  s.driver = std::thread([&s, guided = std::move(guided)] { s.render(guided); });
}

void RenderSession::pause() {
  state_->set_paused(true);
}

void RenderSession::resume() {
  state_->set_paused(false);
}

void RenderSession::stop() {
  {
    const std::lock_guard lock(state_->mutex);
    state_->stop_requested = true;
    state_->changed.notify_all();
  }
  if (state_->driver.joinable()) state_->driver.join();
}

bool RenderSession::wait(double seconds) {
  std::unique_lock lock(state_->mutex);
  const auto over = [this] {
    const SessionState s = state_->progress.state;
    return s != SessionState::rendering && s != SessionState::paused;
  };
  constexpr double kForever = 1e8;  // three years; the clock overflows after three hundred
  if (seconds >= kForever) {
    state_->changed.wait(lock, over);
    return true;
  }
  return state_->changed.wait_for(lock, std::chrono::duration<double>(std::max(0.0, seconds)), over);
}

RenderProgress RenderSession::progress() const {
  const std::lock_guard lock(state_->mutex);
  RenderProgress p = state_->progress;
  if (p.state == SessionState::rendering || p.state == SessionState::paused)
    p.wall_seconds = seconds_since(state_->started);
  p.samples_total = std::max(p.samples_total, p.samples_done);
  if (p.samples_total > 0) p.fraction = static_cast<double>(p.samples_done) / static_cast<double>(p.samples_total);
  if (state_->time_limit > 0) p.fraction = std::max(p.fraction, p.wall_seconds / state_->time_limit);
  p.fraction = p.state == SessionState::finished ? 1.0 : std::min(p.fraction, 1.0);
  return p;
}

std::shared_ptr<const Film> RenderSession::film() const {
  const std::lock_guard lock(state_->mutex);
  return state_->film;
}

}  // namespace alabaster
