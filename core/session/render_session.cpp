#include "core/session/render_session.h"

#include <ctime>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "core/convergence/sample_allocation.h"
#include "core/convergence/group_stopping.h"
#include "core/session/pass_schedule.h"

namespace alabaster {
namespace {

using Clock = std::chrono::steady_clock;

// A render that runs out of time has these at least.
constexpr uint32_t kLeastSamples = 2;

double seconds_since(const Clock::time_point& start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

double thread_cpu_seconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

IntegratorSettings integrator_settings(const RenderSettings& s) {
  IntegratorSettings out;
  out.max_depth = s.max_depth;
  out.roulette_depth = s.roulette_depth;
  out.subsurface = s.subsurface;
  out.inversion = s.inversion;
  out.walk.weights = s.walk_weights;
  const bool shortcuts = s.subsurface != SubsurfaceMode::reference;
  out.walk.guiding = shortcuts && s.walk_guiding;
  out.walk.sphere_steps = shortcuts && s.walk_sphere_steps;
  return out;
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
  mutable std::mutex mutex;  // guards what follows, never held while rendering
  std::condition_variable changed;
  RenderProgress progress;
  std::shared_ptr<Film> film;
  Clock::time_point started;
  bool paused = false;

  std::atomic<bool> stop_requested{false};
  std::atomic<bool> out_of_time{false};
  double limit = 0;  // seconds; 0: none
  std::atomic<bool> pause_requested{false};
  std::thread driver;

  // Changed between rounds only.
  SampleAllocation allocation;
  std::vector<uint32_t> pilot_rays;  // of each pixel, while they are counted; workers write their own tiles' pixels
  GroupStopping stopping;
  struct {
    std::unique_ptr<Film> film;  // what groups showed when they ended; those that others wait for are traced on
    uint32_t groups = 0;
  } ended_early;

  void render(const RenderRequest& request);
  void run_rounds(const RenderRequest& request);
  void run_workers(const RenderRequest& request, const PassSchedule& schedule);
  void look_at_error(const RenderRequest& request, uint32_t samples, const NoiseImage& noise);
  bool end_groups(double target, const NoiseImage& noise);
  void work(const RenderRequest& request, const PassSchedule& schedule);
  bool render_tile(const RenderRequest& request, const PathContext& context, const SampleRange& range, int tile);
  bool may_go_on();
  bool time_is_over();
  void tile_done(const RenderCounters& counters, double cpu_seconds, size_t tiles, size_t items);

  std::atomic<size_t> next_item{0};
  std::vector<std::atomic<uint32_t>> tile_passes;  // passes that each tile has finished
  size_t finished_items = 0;                       // of this round, under mutex
  uint32_t passes_before = 0;                      // this round, under mutex
};

// Blocks while paused. False: stop.
bool RenderSession::State::may_go_on() {
  if (stop_requested.load(std::memory_order_relaxed)) return false;
  if (!pause_requested.load(std::memory_order_relaxed)) return true;
  std::unique_lock lock(mutex);
  changed.wait(lock, [this] { return !paused || stop_requested; });
  return !stop_requested;
}

bool RenderSession::State::time_is_over() {
  if (!(limit > 0)) return false;
  if (!out_of_time.load(std::memory_order_relaxed) && seconds_since(started) >= limit) out_of_time = true;
  return out_of_time.load(std::memory_order_relaxed);
}

bool RenderSession::State::render_tile(const RenderRequest& request, const PathContext& context,
                                       const SampleRange& range, int tile) {
  const RenderSettings& settings = request.settings;
  const PathIntegrator trace =
      select_path_integrator(request.scene->features, context.settings, context.layers != nullptr);
  const PixelRect rect = film->tile_rect(tile);
  FilmTile pixels = film->load_tile(tile);
  const PixelRect& window = film->data_window();
  const uint32_t traced = stopping.traced();
  size_t pixel = 0;
  for (int y = rect.y0; y < rect.y1; ++y) {
    size_t in_window = static_cast<size_t>(y - window.y0) * static_cast<size_t>(window.width()) +
                       static_cast<size_t>(rect.x0 - window.x0);
    for (int x = rect.x0; x < rect.x1; ++x, ++pixel, ++in_window) {
      if (!(traced >> pixel_group(x, y) & 1)) continue;
      const uint32_t seed = pixel_seed(x, y, settings.frame, settings.seed);
      const uint64_t rays_before = context.counters.rays();
      const uint32_t end = allocation.samples(in_window, range.end);
      for (uint32_t s = allocation.samples(in_window, range.begin); s < end; ++s) {
        if (!may_go_on() || (range.begin >= kLeastSamples && time_is_over())) return false;
        const PixelSampler sampler(seed, s);
        const auto u = sampler.draw(Dimension::film_lens, 0);
        const Vec2f offset = sample_pixel_filter(settings.filter, {u[0], u[1]});
        const Vec2f film_position(static_cast<float>(x) + 0.5f + offset.x, static_cast<float>(y) + 0.5f + offset.y);
        FilmSample sample = trace(context, context.camera.generate_ray(film_position, {u[2], u[3]}), sampler);
        ++context.counters.samples;
        if (!is_finite(sample.color)) {
          ++context.counters.nonfinite_samples;
          sample.color = Rgb(0.0f);
          if (context.layers) *context.layers = {};
        }
        pixels.add(pixel, sample, context.layers);
      }
      if (!pilot_rays.empty()) pilot_rays[in_window] += static_cast<uint32_t>(context.counters.rays() - rays_before);
    }
  }
  film->store_tile(tile, std::move(pixels));
  return true;
}

void RenderSession::State::tile_done(const RenderCounters& counters, double cpu_seconds, size_t tiles, size_t items) {
  const std::lock_guard lock(mutex);
  progress.counters.add(counters);
  progress.samples_done = progress.counters.samples;
  progress.cpu_seconds += cpu_seconds;
  ++finished_items;
  progress.passes_done =
      passes_before + static_cast<uint32_t>(finished_items >= items ? items / tiles : finished_items / tiles);
}

// Work items are (pass, tile) in order. Passes overlap, so no worker idles at the end of one; a tile's passes do not:
// its sums must be taken in sample order whoever takes them.
void RenderSession::State::work(const RenderRequest& request, const PassSchedule& schedule) {
  const Camera camera(request.camera, request.width, request.height, request.scene->origin);
  const IntegratorSettings settings = integrator_settings(request.settings);
  const auto tiles = static_cast<size_t>(film->tile_count());
  const size_t items = tiles * schedule.size();
  while (true) {
    const size_t item = next_item.fetch_add(1);
    if (item >= items) return;
    const size_t tile = item % tiles;
    const auto pass = static_cast<uint32_t>(item / tiles);
    for (uint32_t done; (done = tile_passes[tile].load()) != pass && !stop_requested;) tile_passes[tile].wait(done);
    const double cpu = thread_cpu_seconds();
    RenderCounters counters;
    LightLayers layers;
    const PathContext context{*request.scene, camera, settings, counters,
                              request.aovs & kLayerAovs ? &layers : nullptr};
    // Released also when an exception passes: nobody may wait for a tile that nobody works on.
    const TileRelease release{tile_passes[tile], pass};
    try {
      if (stop_requested || !render_tile(request, context, schedule[pass], static_cast<int>(tile))) return;
    } catch (...) {
      stop_requested = true;  // before the tile is released: the others end, too
      throw;
    }
    tile_done(counters, thread_cpu_seconds() - cpu, tiles, items);
  }
}

void RenderSession::State::run_workers(const RenderRequest& request, const PassSchedule& schedule) {
  next_item = 0;
  tile_passes = std::vector<std::atomic<uint32_t>>(static_cast<size_t>(film->tile_count()));
  {
    const std::lock_guard lock(mutex);
    finished_items = 0;
    passes_before = progress.passes_done;
  }
  // TBB prints a warning when an arena asks for more than the process may have: never ask.
  const auto allowed = tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
  const auto threads =
      static_cast<int>(std::min<size_t>(request.settings.threads > 0 ? request.settings.threads : allowed, allowed));
  tbb::task_arena arena(threads);
  arena.execute([&] {
    tbb::parallel_for(
        0, arena.max_concurrency(), [&](int) { work(request, schedule); }, tbb::simple_partitioner());
  });
}

// One round, unless the error decides or the samples are dealt out: then what decides is looked at when all tiles have
// the same part of their samples, so that it does not depend on threads.
void RenderSession::State::run_rounds(const RenderRequest& request) {
  const RenderSettings& settings = request.settings;
  const bool deals = settings.adaptive && settings.samples >= 2 * kPilotSamples;
  const bool asks = settings.target_error > 0;
  if (deals) pilot_rays.resize(progress.pixels);
  SampleRange round{0, asks || deals ? std::min(settings.samples, kPilotSamples) : settings.samples};
  while (round.begin < round.end) {
    run_workers(request, make_pass_schedule(round));
    const NoiseImage noise = film_noise(*film);
    look_at_error(request, round.end, noise);
    if (stop_requested || out_of_time) break;
    if (deals && round.begin == 0) {
      allocation = SampleAllocation(*film, pilot_rays, asks ? 0 : settings.samples);
      pilot_rays = {};
    }
    if (asks && end_groups(settings.target_error, noise)) break;
    round = {round.end, std::min(settings.samples, asks ? next_look(round.end) : settings.samples)};
  }
  if (!ended_early.film) return;
  take_groups(*ended_early.film, ended_early.groups, film.get());
  look_at_error(request, round.end, film_noise(*film));
}

// Whether all have ended.
bool RenderSession::State::end_groups(double target, const NoiseImage& noise) {
  std::array<FrameError, kPixelGroups> errors;
  for (int g = 0; g < kPixelGroups; ++g)
    errors[static_cast<size_t>(g)] = estimate_frame_error(group_image(film->data_window(), noise.pixels, g).noise);
  const uint32_t ending = stopping.decide(errors, target);
  if (stopping.all_ended()) return true;
  if (!ending) return false;
  if (!ended_early.film) ended_early.film = std::make_unique<Film>(film->data_window(), film->aovs());
  take_groups(*film, ending, ended_early.film.get());
  ended_early.groups |= ending;
  return false;
}

// Predicts the total, too.
void RenderSession::State::look_at_error(const RenderRequest& request, uint32_t samples, const NoiseImage& noise) {
  const FrameError error = estimate_frame_error(noise);
  const std::lock_guard lock(mutex);
  progress.noise = error;
  if (request.settings.target_error > 0 && error.known)
    progress.samples_total = progress.pixels * samples_for_error(samples, request.settings.samples, error.relative_rmse,
                                                                 request.settings.target_error);
}

// Nothing may leave the driver thread: an exception there would end the host.
void RenderSession::State::render(const RenderRequest& request) {
  std::string error;
  try {
    run_rounds(request);
  } catch (const std::exception& e) {
    error = std::string("rendering failed: ") + e.what();
  } catch (...) {
    error = "rendering failed";
  }
  const std::lock_guard lock(mutex);
  progress.state = !error.empty()   ? SessionState::failed
                   : stop_requested ? SessionState::stopped
                                    : SessionState::finished;
  progress.error = std::move(error);
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
    s.film = std::make_shared<Film>(request.data_window, request.aovs);
    s.progress = {};
    s.progress.state = SessionState::rendering;
    s.progress.scene_number = request.scene->number;
    s.progress.pixels = static_cast<uint64_t>(std::max(0, request.data_window.width())) *
                        static_cast<uint64_t>(std::max(0, request.data_window.height()));
    s.progress.samples_total = s.progress.pixels * request.settings.samples;
    s.started = Clock::now();
    s.limit = std::max(0.0, static_cast<double>(request.settings.time_limit));
    s.paused = false;
  }
  s.allocation = {};
  s.pilot_rays = {};
  s.stopping = {};
  s.ended_early = {};
  s.stop_requested = false;
  s.out_of_time = false;
  s.pause_requested = false;
  s.driver = std::thread([&s, request] { s.render(request); });
}

void RenderSession::pause() {
  const std::lock_guard lock(state_->mutex);
  if (state_->progress.state != SessionState::rendering) return;
  state_->paused = true;
  state_->pause_requested = true;
  state_->progress.state = SessionState::paused;
}

void RenderSession::resume() {
  const std::lock_guard lock(state_->mutex);
  if (state_->progress.state != SessionState::paused) return;
  state_->paused = false;
  state_->pause_requested = false;
  state_->progress.state = SessionState::rendering;
  state_->changed.notify_all();
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
  return state_->changed.wait_for(lock, std::chrono::duration<double>(std::max(0.0, seconds)), over);
}

RenderProgress RenderSession::progress() const {
  const std::lock_guard lock(state_->mutex);
  RenderProgress p = state_->progress;
  if (p.state == SessionState::rendering || p.state == SessionState::paused)
    p.wall_seconds = seconds_since(state_->started);
  p.samples_total = std::max(p.samples_total, p.samples_done);
  if (p.samples_total > 0) p.fraction = static_cast<double>(p.samples_done) / static_cast<double>(p.samples_total);
  if (state_->limit > 0) p.fraction = std::max(p.fraction, p.wall_seconds / state_->limit);
  p.fraction = p.state == SessionState::finished ? 1.0 : std::min(p.fraction, 1.0);
  return p;
}

std::shared_ptr<const Film> RenderSession::film() const {
  const std::lock_guard lock(state_->mutex);
  return state_->film;
}

}  // namespace alabaster
