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
#include <numeric>
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
#include "core/session/worker_threads.h"

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

bool is_adaptive(const RenderSettings& settings) {
  return settings.adaptive && settings.samples >= 2 * kPilotSamples;
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
  RenderRequest request;        // of the current or last render
  bool noise_is_known = false;  // progress.noise is the film's
  Clock::time_point started;
  PassSchedule schedule;  // of the current round
  FinishedPasses finished{0, 0};
  uint32_t passes_before = 0;                // in earlier rounds
  std::shared_ptr<const Denoiser> denoiser;  // null: none is asked for, or the film is denoised
  uint32_t denoise_threads = 0;

  std::atomic<bool> stop_requested{false};
  tbb::task_group_context measuring;  // stop() cancels it
  std::atomic<bool> out_of_time{false};
  double time_limit = 0;                     // seconds; 0: none
  std::atomic<bool> pause_requested{false};  // changed under the mutex
  std::mutex stopped_denoise;                // one caller denoises a stopped film, and the others wait for it
  std::thread driver;

  // Changed between rounds only.
  std::vector<int> tile_order;  // from the centre outwards
  SampleAllocation allocation;
  GroupStopping stopping;

  // Work of the current round.
  std::atomic<size_t> next_item{0};
  std::vector<std::atomic<uint32_t>> tile_passes;  // passes that each tile has finished

  void begin(const RenderRequest& next);
  void render();
  void run_rounds(int threads);
  void run_workers(const TileRenderer& renderer, const SampleRange& round, int threads);
  void render_items(const TileRenderer& renderer);
  bool render_tile(const TileRenderer& renderer, const SamplePass& pass, int tile, RenderCounters* counters);
  void set_paused(bool pause);
  bool wait_while_paused();
  bool time_is_over();
  void tile_done(uint32_t pass, bool done, const RenderCounters& counters, double cpu_seconds);
  NoiseImage measure_noise(uint32_t samples);
  void denoise(const Film* stopped);
  void measure_stopped();
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

void RenderSession::State::tile_done(uint32_t pass, bool done, const RenderCounters& counters, double cpu_seconds) {
  const std::lock_guard lock(mutex);
  progress.counters.add(counters);
  progress.samples_done = progress.counters.samples;
  progress.cpu_seconds += cpu_seconds;
  if (!done) return;
  finished.add_tile(pass);
  progress.passes_done = passes_before + count_whole_passes(schedule, finished.count());
}

// Work items are (pass, tile) in order. Passes overlap, so that no worker idles at the end of one. The passes of one
// tile do not: its sums are taken in sample order, by whichever worker.
void RenderSession::State::render_items(const TileRenderer& renderer) {
  const size_t tiles = tile_order.size();
  const size_t items = tiles * schedule.size();
  while (true) {
    // Take the next item, and wait until the tile's pass before it is done.
    const size_t item = next_item.fetch_add(1);
    if (item >= items) return;
    const int tile = tile_order[item % tiles];
    const auto pass = static_cast<uint32_t>(item / tiles);
    std::atomic<uint32_t>& passes = tile_passes[static_cast<size_t>(tile)];
    for (uint32_t done; (done = passes.load()) != pass && !stop_requested;) passes.wait(done);

    // Render it. The tile is released also when an exception passes: nobody may wait for a tile that nobody works on.
    const double cpu = cpu_seconds(CLOCK_THREAD_CPUTIME_ID);
    RenderCounters counters;
    const TileRelease release{passes, pass};
    bool done = false;
    try {
      done = !stop_requested && render_tile(renderer, schedule[pass], tile, &counters);
    } catch (...) {
      stop_requested = true;  // before the tile is released: the other workers end, too
      throw;
    }

    // Report it.
    tile_done(pass, done, counters, cpu_seconds(CLOCK_THREAD_CPUTIME_ID) - cpu);
    if (!done) return;
  }
}

bool RenderSession::State::render_tile(const TileRenderer& renderer, const SamplePass& pass, int tile,
                                       RenderCounters* counters) {
  const auto may_go_on = [&] { return wait_while_paused() && (pass.end <= kLeastSamples || !time_is_over()); };
  const TileSamples samples{film->tile_rect(tile), pass, allocation, stopping.groups_to_trace()};
  FilmWriter pixels(film.get(), tile);
  return renderer.render(samples, may_go_on, &pixels, counters);
}

// Renders one round.
void RenderSession::State::run_workers(const TileRenderer& renderer, const SampleRange& round, int threads) {
  next_item = 0;
  tile_passes = std::vector<std::atomic<uint32_t>>(tile_order.size());
  {
    const std::lock_guard lock(mutex);
    noise_is_known = false;
    schedule = make_pass_schedule(round);
    passes_before = progress.passes_done;
    finished = FinishedPasses(tile_passes.size(), schedule.size());
  }
  run_on_threads(threads, [&] { render_items(renderer); });
}

// A frame is rendered in rounds. All decisions fall between rounds, when every tile stands at the same sample, so they
// do not depend on threads. The caller is in an arena of `threads`.
void RenderSession::State::run_rounds(int threads) {
  const RenderSettings& settings = request.settings;
  const bool has_target = settings.target_error > 0;
  const bool adaptive = is_adaptive(settings);
  const TileRenderer renderer(request);

  // Where decisions follow, the first round is a pilot; else it is the rest of the frame.
  SampleRange round{film->least_samples(),
                    has_target || adaptive ? std::min(settings.samples, kPilotSamples) : settings.samples};
  while (round.begin < round.end) {
    // Trace the round's samples and measure the error that is left.
    run_workers(renderer, round, threads);
    if (stop_requested) break;
    const NoiseImage noise = measure_noise(round.end);
    if (stop_requested || out_of_time) break;

    // After the pilot, send the samples to where they help most.
    if (adaptive && round.begin == 0)
      allocation = SampleAllocation(*film, film->rays(), has_target ? 0 : settings.samples);

    // End the groups of pixels that have reached the target.
    if (has_target) {
      stopping.update(*film, noise, settings.target_error);
      if (stopping.all_ended()) break;
    }

    // Go on to the next check of the error, or to the end.
    round = {round.end, has_target ? std::min(settings.samples, next_error_check(round.end)) : settings.samples};
  }

  // Groups that ended before others show what they had then.
  if (stopping.restore_ended(film.get()) && !stop_requested) measure_noise(round.end);
}

// Measures what the film has, and reports its error. Where a target decides, the error also predicts how many samples
// the frame will take. A stop cancels it: then what it returns is not to be used.
NoiseImage RenderSession::State::measure_noise(uint32_t samples) {
  NoiseImage noise;
  FrameError error;
  const auto measure = [&](int) {
    noise = film_noise(*film);
    error = estimate_frame_error(noise);
  };
  tbb::parallel_for(0, 1, measure, tbb::simple_partitioner(), measuring);
  const RenderSettings& settings = request.settings;
  const std::lock_guard lock(mutex);
  if (stop_requested) return noise;
  progress.noise = error;
  noise_is_known = true;
  if (settings.target_error > 0 && error.known)
    progress.samples_total =
        progress.pixels * samples_for_error(samples, settings.samples, error.relative_rmse, settings.target_error);
  return noise;
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
void RenderSession::State::render() {
  std::string error;
  std::optional<SampleAddress> failed_sample;
  try {
    // TBB prints a warning when an arena asks for more threads than the process may have, so never ask.
    const auto allowed = tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
    const uint32_t asked = request.settings.threads;
    tbb::task_arena arena(static_cast<int>(std::min<size_t>(asked > 0 ? asked : allowed, allowed)));
    arena.execute([&] { run_rounds(arena.max_concurrency()); });
    if (!stop_requested) denoise(nullptr);
  } catch (const SampleFailure& failure) {
    error = failure_text(failure.what());
    failed_sample = failure.at;
  } catch (const std::exception& e) {
    error = failure_text(e.what());
  } catch (...) {
    error = failure_text("unknown reason");
  }
  film->set_ended(true);
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

namespace {

// From the centre outwards; row by row where the distance is the same.
std::vector<int> tiles_from_centre(const Film& film) {
  const PixelRect& window = film.data_window();
  const auto distance = [&](int tile) {
    const PixelRect r = film.tile_rect(tile);
    const int64_t x = r.x0 + r.x1 - window.x0 - window.x1, y = r.y0 + r.y1 - window.y0 - window.y1;
    return x * x + y * y;
  };
  std::vector<int> tiles(static_cast<size_t>(film.tile_count()));
  std::iota(tiles.begin(), tiles.end(), 0);
  std::stable_sort(tiles.begin(), tiles.end(), [&](int a, int b) { return distance(a) < distance(b); });
  return tiles;
}

// True if the samples of a render that has ended are the first of another. Where decisions follow from samples, they
// depend on the settings.
bool goes_on(const RenderRequest& last, const RenderRequest& next) {
  RenderSettings settings = last.settings;
  settings.samples = next.settings.samples;
  settings.time_limit = next.settings.time_limit;
  settings.threads = next.settings.threads;
  settings.denoise = next.settings.denoise;
  return last.scene == next.scene && last.camera == next.camera && last.width == next.width &&
         last.height == next.height && last.data_window == next.data_window && (next.aovs & ~last.aovs) == 0 &&
         settings == next.settings && !settings.adaptive && settings.target_error == 0;
}

}  // namespace

// Under the mutex.
void RenderSession::State::begin(const RenderRequest& next) {
  const uint64_t pixels = static_cast<uint64_t>(std::max(0, next.data_window.width())) *
                          static_cast<uint64_t>(std::max(0, next.data_window.height()));
  RenderProgress before;
  const FilmExtras extras{is_adaptive(next.settings), {}};
  if (film && progress.state != SessionState::failed && goes_on(request, next) &&
      film->most_samples() <= next.settings.samples) {
    if (!progress.denoiser.empty()) film->store_denoised({});
    before = std::move(progress);
  } else if (film && film.use_count() == 1 && film->data_window() == next.data_window && film->aovs() == next.aovs &&
             film->extras().rays == extras.rays) {
    film->clear();  // to take new memory would cost tens of milliseconds
  } else {
    film = nullptr;
    film = std::make_shared<Film>(next.data_window, next.aovs, extras);
    tile_order = tiles_from_centre(*film);
  }
  film->set_ended(false);
  request = next;
  request.aovs = film->aovs();  // those of a film that goes on may be more
  denoiser = next.aovs & aov_bit(Aov::denoised) ? next.denoiser : nullptr;
  denoise_threads = next.settings.threads;
  progress = {};
  progress.state = SessionState::rendering;
  progress.scene_number = next.scene->number;
  progress.pixels = pixels;
  progress.samples_done = before.samples_done;
  progress.samples_total = pixels * next.settings.samples;
  progress.passes_done = before.passes_done;
  progress.cpu_seconds = before.cpu_seconds;
  progress.counters = before.counters;
  noise_is_known = false;
  started =
      Clock::now() - std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(before.wall_seconds));
  time_limit = std::max(0.0, static_cast<double>(next.settings.time_limit));
  pause_requested = false;
}

void RenderSession::start(const RenderRequest& request) {
  stop();
  State& s = *state_;
  RenderRequest guided = request;
  guided.aovs = with_guides(request.aovs);
  {
    const std::lock_guard lock(s.mutex);
    s.begin(guided);
  }
  s.allocation = {};
  s.stopping = {};
  s.stop_requested = false;
  s.measuring.reset();
  s.out_of_time = false;
  s.driver = std::thread([&s] { s.render(); });
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
    state_->measuring.cancel_group_execution();
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

// Stop does not wait for the noise to be measured: who asks does.
void RenderSession::State::measure_stopped() {
  std::shared_ptr<const Film> measured;
  {
    const std::lock_guard lock(mutex);
    if (noise_is_known || progress.state != SessionState::stopped) return;
    measured = film;
  }
  const FrameError error = estimate_frame_error(film_noise(*measured));
  const std::lock_guard lock(mutex);
  if (measured != film || progress.state != SessionState::stopped) return;
  progress.noise = error;
  noise_is_known = true;
}

RenderProgress RenderSession::progress() const {
  state_->measure_stopped();
  const std::lock_guard lock(state_->mutex);
  RenderProgress p = state_->progress;
  if (p.state == SessionState::rendering || p.state == SessionState::paused)
    p.wall_seconds = seconds_since(state_->started);
  p.covered = state_->film && state_->film->is_covered();
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
