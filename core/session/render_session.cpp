#include "core/session/render_session.h"

#include <algorithm>
#include <exception>
#include <numeric>
#include <utility>

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include "core/denoise/denoise_film.h"
#include "core/session/session_state.h"

namespace alabaster {
namespace {

// Memory may have run out, and then a report must need none: the short text fits into the string itself.
std::string failure_text(const char* what) noexcept {
  try {
    return std::string("rendering failed: ") + what;
  } catch (...) {
    return "out of memory";
  }
}

}  // namespace

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
  const SessionClock::time_point begun = SessionClock::now();
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
    arena.execute([&] {
      if (request.scene) run_rounds(arena.max_concurrency());
      if (!stop_requested && !noise_is_known) measure_noise(round.end);
    });
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

FilmExtras extras_of(const RenderSettings& settings) {
  FilmExtras extras{is_adaptive(settings), {}};
  if (settings.first_sample > 0) extras.range = {settings.first_sample, settings.samples};
  return extras;
}

bool decides(const RenderSettings& settings) {
  return settings.adaptive || settings.target_error > 0;
}

// True if the samples of a render that has ended are the first of another. Where decisions follow from samples, they
// depend on the settings, and on how many samples there will be.
bool goes_on(const RenderRequest& last, const RenderRequest& next) {
  RenderSettings settings = last.settings;
  if (settings.first_sample == 0 && !decides(settings)) settings.samples = next.settings.samples;
  settings.time_limit = next.settings.time_limit;
  settings.threads = next.settings.threads;
  settings.denoise = next.settings.denoise;
  return last.scene == next.scene && last.camera == next.camera && last.width == next.width &&
         last.height == next.height && last.data_window == next.data_window && (next.aovs & ~last.aovs) == 0 &&
         last.primvars == next.primvars && settings == next.settings;
}

}  // namespace

// Under the mutex.
bool RenderSession::State::has_first_samples_of(const RenderRequest& next) const {
  if (!film || progress.state == SessionState::failed || restored || !goes_on(request, next)) return false;
  // A time limit ends the last round of a decided render early, and its decisions with it.
  return decides(next.settings) ? !out_of_time : film->most_samples() <= next.settings.samples;
}

// Under the mutex.
void RenderSession::State::begin(const RenderRequest& next) {
  const uint64_t pixels = static_cast<uint64_t>(std::max(0, next.data_window.width())) *
                          static_cast<uint64_t>(std::max(0, next.data_window.height()));
  RenderProgress before;
  const FilmExtras extras = extras_of(next.settings);
  const bool more = has_first_samples_of(next);
  if (!more || !decides(next.settings)) {
    allocation = {};
    stopping = {};
    round = {};
  }
  restored = false;
  if (next.resumed) {
    RenderState& from = *next.resumed;
    film = std::move(from.film);
    allocation = std::move(from.allocation);
    stopping = std::move(from.stopping);
    round = from.round;
    before.wall_seconds = from.wall_seconds, before.cpu_seconds = from.cpu_seconds;
    before.counters = from.counters;
    before.samples_done = from.counters.samples;
    tile_order = tiles_from_centre(*film);
  } else if (more) {
    if (!progress.denoiser.empty()) film->store_denoised({});
    before = std::move(progress);
  } else if (film && film.use_count() == 1 && film->data_window() == next.data_window && film->aovs() == next.aovs &&
             film->extras() == extras) {
    film->clear();  // to take new memory would cost tens of milliseconds
  } else {
    film = nullptr;
    film = std::make_shared<Film>(next.data_window, next.aovs, extras);
    tile_order = tiles_from_centre(*film);
  }
  film->set_ended(false);
  request = next;
  request.aovs = film->aovs();  // those of a film that goes on may be more
  request.resumed = nullptr;
  denoiser = next.aovs & aov_bit(Aov::denoised) ? next.denoiser : nullptr;
  denoise_threads = next.settings.threads;
  progress = {};
  progress.state = SessionState::rendering;
  progress.scene_number = next.scene ? next.scene->number : 0;
  progress.pixels = pixels;
  progress.samples_done = before.samples_done;
  progress.samples_total = pixels * (next.settings.samples - std::min(next.settings.samples, extras.range.begin));
  // A round that was stopped counts its passes again.
  const bool is_within_round = more && decides(next.settings) && before.state == SessionState::stopped;
  progress.passes_done = is_within_round ? std::min(passes_before, before.passes_done) : before.passes_done;
  progress.cpu_seconds = before.cpu_seconds;
  progress.counters = before.counters;
  progress.noise = before.noise, progress.noise_samples = before.noise_samples;
  noise_is_known = false;
  noise_asked = false;
  started = SessionClock::now() -
            std::chrono::duration_cast<SessionClock::duration>(std::chrono::duration<double>(before.wall_seconds));
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
  s.stop_requested = false;
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
    state_->changed.notify_all();
  }
  if (state_->driver.joinable()) state_->driver.join();
}

void RenderSession::ask_for_noise() {
  state_->noise_asked = true;
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
  progress.noise_samples = progress.samples_done;
  noise_is_known = true;
}

bool RenderSession::save(const BlockSink& sink) {
  State& s = *state_;
  const std::lock_guard still(s.decisions);
  RenderState state;
  bool ended = false;
  {
    const std::lock_guard lock(s.mutex);
    const SessionState now = s.progress.state;
    ended = now == SessionState::stopped || now == SessionState::finished;
    const bool runs = (now == SessionState::rendering || now == SessionState::paused) && !s.stop_requested;
    if (s.restored || (!ended && !runs)) return false;
    state.film = s.film;
    state.counters = s.progress.counters;
    state.cpu_seconds = s.progress.cpu_seconds;
    state.wall_seconds = ended ? s.progress.wall_seconds : seconds_since(s.started);
  }
  state.round = s.round;
  state.allocation = s.allocation;
  state.stopping = s.stopping;
  // A stop does not wait for the disk.
  return write_state(state,
                     [&](std::span<const std::byte> block) { return (ended || !s.stop_requested) && sink(block); });
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
