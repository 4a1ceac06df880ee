#include "core/session/running_render.h"

#include <algorithm>
#include <exception>
#include <numeric>
#include <utility>

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include "core/denoise/denoise_film.h"

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

// From the centre outwards; row by row where the distance is the same.
std::shared_ptr<const std::vector<int>> tiles_from_centre(const Film& film) {
  const PixelRect& window = film.data_window();
  const auto distance = [&](int tile) {
    const PixelRect r = film.tile_rect(tile);
    const int64_t x = r.x0 + r.x1 - window.x0 - window.x1, y = r.y0 + r.y1 - window.y0 - window.y1;
    return x * x + y * y;
  };
  std::vector<int> tiles(static_cast<size_t>(film.tile_count()));
  std::iota(tiles.begin(), tiles.end(), 0);
  std::stable_sort(tiles.begin(), tiles.end(), [&](int a, int b) { return distance(a) < distance(b); });
  return std::make_shared<const std::vector<int>>(std::move(tiles));
}

// The samples that a film has got. No thread changes it.
uint64_t samples_of(const Film& film) {
  uint64_t sum = 0;
  for (int tile = 0; tile < film.tile_count(); ++tile) {
    const PixelRect rect = film.tile_rect(tile);
    const auto pixels = static_cast<size_t>(rect.width()) * static_cast<size_t>(rect.height());
    for (size_t i = 0; i < pixels; ++i) sum += film.next_sample(tile, i) - film.extras().range.begin;
  }
  return sum;
}

// A frame of which no ray could be traced is black, and looks converged. Empty: some could.
std::string rejection_text(const RenderCounters& counters) {
  if (counters.camera_rays == 0 || counters.rejected_rays < counters.camera_rays) return {};
  return "no ray of the camera could be traced: it stands or looks beyond 1e17 units, or its transform gives no finite "
         "rays; scale the scene and its camera down, or move the camera nearer";
}

bool decides(const RenderSettings& settings) {
  return settings.adaptive || settings.target_error > 0;
}

}  // namespace

// Decisions that follow from samples also depend on the settings, and on how many samples there will be.
bool RenderSession::can_continue(const RenderRequest& last, const RenderRequest& next) {
  RenderSettings settings = last.settings;
  for (const SettingParameter& setting : setting_parameters())
    if (setting.of & setting_use::kContinues)
      std::visit([&](auto member) { settings.*member = next.settings.*member; }, setting.member);
  if (settings.first_sample > 0 || decides(settings)) settings.samples = last.settings.samples;
  return last.scene == next.scene && last.camera == next.camera && last.width == next.width &&
         last.height == next.height && last.data_window == next.data_window && (next.aovs & ~last.aovs) == 0 &&
         last.primvars == next.primvars && last.light_groups == next.light_groups && settings == next.settings;
}

// Under the mutex. This render has ended if `next` continues it; else it may still run.
bool RenderSession::Render::can_be_continued_by(const RenderRequest& next) const {
  if (!can_continue(request, next) || !film || progress.state == SessionState::failed || cut_short) return false;
  // A time limit ends the last round of a decided render early, and its decisions with it.
  return decides(next.settings) ? !out_of_time : film->most_samples() <= next.settings.samples;
}

RenderSession::Render::Render(const RenderRequest& next, Render* last, DeferredNotifier* polled)
    : request(next), notifier(polled) {
  const std::lock_guard lock(last->mutex);
  RenderProgress before;
  const bool more = !next.resumed && last->can_be_continued_by(next);
  if (next.resumed)
    before = continue_checkpoint(next.resumed.get());
  else if (more)
    before = continue_render(*last);
  else
    film = std::make_shared<Film>(next.data_window, next.aovs, film_extras(next.settings, next.light_groups.size()));
  const bool same_tiles = last->tile_order && last->request.data_window == film->data_window();
  tile_order = same_tiles ? last->tile_order : tiles_from_centre(*film);
  film->set_ended(false);
  film->count_ids_in(next.memory);
  request.aovs = film->aovs();  // a film that is continued may have more
  request.resumed = nullptr;
  if (next.aovs & aov_bit(Aov::denoised)) denoiser = next.denoiser;
  show_begin(before);
  // A round that was stopped counts its passes again.
  if (more && decides(next.settings) && before.state == SessionState::stopped)
    progress.passes_done = std::min(last->passes_before, before.passes_done);
}

// Takes the film and decisions of a checkpoint. Returns the progress of the render that wrote it.
RenderProgress RenderSession::Render::continue_checkpoint(RenderState* from) {
  film = std::move(from->film);
  allocation = std::move(from->allocation);
  stopping = std::move(from->stopping);
  round = from->round;
  RenderProgress before;
  before.wall_seconds = from->wall_seconds, before.cpu_seconds = from->cpu_seconds;
  before.counters = from->counters;
  // The tiles of a running render are saved later than its counters. A film that is done has lost the samples that
  // ended groups of pixels took meanwhile.
  if (round.begin < round.end) before.counters.samples = samples_of(*film);
  before.samples_done = before.counters.samples;
  return before;
}

// Takes the film and decisions of a render that has ended, under its mutex. Returns its progress.
RenderProgress RenderSession::Render::continue_render(const Render& last) {
  film = last.film;
  if (!last.progress.denoiser.empty()) film->store_denoised({});
  if (decides(request.settings)) allocation = last.allocation, stopping = last.stopping, round = last.round;
  return last.progress;
}

void RenderSession::Render::show_begin(const RenderProgress& before) {
  const uint64_t pixels = static_cast<uint64_t>(std::max(0, request.data_window.width())) *
                          static_cast<uint64_t>(std::max(0, request.data_window.height()));
  const uint32_t first = film->extras().range.begin;
  progress.state = SessionState::rendering;
  progress.scene_number = request.scene ? request.scene->number : 0;
  progress.pixels = pixels;
  progress.samples_done = before.samples_done;
  uint32_t most = request.settings.samples;
  // Most frames with a target end long before their cap. The first estimate of the error tells more.
  if (request.settings.target_error > 0 && !before.noise.known) most = std::min(most, 8 * kPilotSamples);
  progress.samples_total = pixels * (most - std::min(most, first));
  progress.passes_done = before.passes_done;
  progress.cpu_seconds = before.cpu_seconds;
  progress.counters = before.counters;
  progress.noise = before.noise, progress.noise_samples = before.noise_samples;
  progress.target_error = static_cast<double>(request.settings.target_error);
  started = SessionClock::now() -
            std::chrono::duration_cast<SessionClock::duration>(std::chrono::duration<double>(before.wall_seconds));
  time_limit = std::max(0.0, static_cast<double>(request.settings.time_limit));
}

// New memory would take tens of milliseconds. `last` needs its film no more, because this render has replaced it.
void RenderSession::Render::take_film_memory(Render* last) {
  std::shared_ptr<Film> old;
  {
    const std::lock_guard lock(last->mutex);
    old.swap(last->film);
  }
  if (old.use_count() == 1) film->take_memory(old.get());
}

void RenderSession::Render::request_stop() {
  const std::lock_guard lock(mutex);
  stop_requested = cancelled = true;
  changed.notify_all();
}

// Another render has replaced this one before it began.
void RenderSession::Render::mark_dropped() {
  const std::lock_guard lock(mutex);
  progress.state = SessionState::stopped;
  changed.notify_all();
}

bool RenderSession::Render::wait(double seconds) {
  std::unique_lock lock(mutex);
  const auto over = [this] {
    return progress.state != SessionState::rendering && progress.state != SessionState::paused;
  };
  constexpr double kForever = 1e8;  // three years; the clock overflows after three hundred
  if (seconds >= kForever) {
    changed.wait(lock, over);
    return true;
  }
  return changed.wait_for(lock, std::chrono::duration<double>(std::max(0.0, seconds)), over);
}

// False: stop.
bool RenderSession::Render::wait_while_paused() {
  if (stop_requested.load(std::memory_order_relaxed)) return false;
  if (!pause_requested.load(std::memory_order_acquire)) return true;
  const DeferredNotifier::PollingPause pause(notifier);
  std::unique_lock lock(mutex);
  changed.wait(lock, [this] { return !pause_requested || stop_requested; });
  return !stop_requested;
}

// Under the mutex. Without pauses.
double RenderSession::Render::seconds_rendered() const {
  const auto end = progress.state == SessionState::paused ? paused : SessionClock::now();
  return std::chrono::duration<double>(end - started.load()).count();
}

void RenderSession::Render::set_paused(bool pause) {
  const std::lock_guard lock(mutex);
  if (progress.state != (pause ? SessionState::rendering : SessionState::paused)) return;
  if (pause)
    paused = SessionClock::now();
  else
    started = started.load() + (SessionClock::now() - paused);
  pause_requested = pause;  // last: a worker that goes on counts from the new start
  progress.state = pause ? SessionState::paused : SessionState::rendering;
  changed.notify_all();
}

// Denoises the film of the render that the driver has just ended, or, unless null, `stopped` if it is this one's.
// Takes the denoiser, so that a film is denoised once. A cancelled call gives it back.
void RenderSession::Render::denoise(const Film* stopped) {
  std::shared_ptr<const Denoiser> taken;
  std::shared_ptr<Film> shown;
  {
    const std::lock_guard lock(mutex);
    if (stopped && (film.get() != stopped || progress.state != SessionState::stopped)) return;
    taken.swap(denoiser);
    shown = film;
  }
  if (!taken) return;
  DenoiseOptions options;
  options.threads = request.settings.threads;
  options.progress = [&](double fraction) {
    const std::lock_guard lock(mutex);
    progress.denoised = fraction;
    return stopped || !stop_requested;
  };
  const SessionClock::time_point begun = SessionClock::now();
  const double cpu = cpu_seconds(CLOCK_PROCESS_CPUTIME_ID);
  std::string problem;
  const DenoiseStatus status = denoise_film(*taken, options, shown.get(), &problem);
  const std::lock_guard lock(mutex);
  progress.denoise_seconds += seconds_since(begun);
  progress.denoise_cpu_seconds += cpu_seconds(CLOCK_PROCESS_CPUTIME_ID) - cpu;
  if (status == DenoiseStatus::cancelled) denoiser = taken;
  if (status == DenoiseStatus::done) progress.denoiser = taken->name();
  if (status == DenoiseStatus::failed) progress.denoise_error = problem;
}

// Nothing may leave the driver thread: an exception there would end the host.
void RenderSession::Render::render() {
  std::string error;
  std::optional<SampleAddress> failed_sample;
  try {
    // TBB prints a warning when an arena asks for more threads than the process may have, so never ask.
    const auto allowed = tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
    const uint32_t asked = request.settings.threads;
    tbb::task_arena arena(static_cast<int>(std::min<size_t>(asked > 0 ? asked : allowed, allowed)));
    arena.execute([&] {
      if (request.scene && !stop_requested) run_rounds(arena.max_concurrency());
      if (!request.scene) show_ended_groups();
      if (!stop_requested && !noise_is_known) measure_noise(round.end);
    });
    {
      const std::lock_guard lock(mutex);
      error = rejection_text(progress.counters);
    }
    if (!stop_requested && error.empty()) denoise(nullptr);
  } catch (const SampleFailure& failure) {
    error = failure_text(failure.what());
    failed_sample = failure.at;
  } catch (const std::exception& e) {
    error = failure_text(e.what());
  } catch (...) {
    error = failure_text("unknown reason");
  }
  film->set_ended(true);
  const uint64_t pixels_without_sample = film->pixels_without_sample();
  const std::lock_guard lock(mutex);
  progress.pixels_without_sample = pixels_without_sample;
  progress.wall_seconds = seconds_rendered();
  progress.state = !error.empty()   ? SessionState::failed
                   : stop_requested ? SessionState::stopped
                                    : SessionState::finished;
  progress.error = std::move(error);
  progress.failed_sample = failed_sample;
  changed.notify_all();
}

// The noise of a stopped render is measured in the thread that asks for progress: stop() does not wait for it.
void RenderSession::Render::measure_stopped() {
  std::shared_ptr<const Film> measured;
  {
    const std::lock_guard lock(mutex);
    if (noise_is_known || progress.state != SessionState::stopped) return;
    measured = film;
  }
  if (!measured) return;
  const FrameError error = estimate_frame_error(film_noise(*measured));
  const std::lock_guard lock(mutex);
  progress.noise = error;
  progress.noise_samples = progress.samples_done;
  noise_is_known = true;
}

bool RenderSession::Render::save(const BlockSink& sink) {
  const std::lock_guard still(decisions);
  RenderState state;
  bool ended = false;
  {
    const std::lock_guard lock(mutex);
    const SessionState now = progress.state;
    ended = now == SessionState::stopped || now == SessionState::finished;
    const bool runs = (now == SessionState::rendering || now == SessionState::paused) && !stop_requested;
    if (!film || (!ended && !runs)) return false;
    state.film = film;
    state.counters = progress.counters;
    state.cpu_seconds = progress.cpu_seconds;
    state.wall_seconds = ended ? progress.wall_seconds : seconds_rendered();
  }
  state.round = round;
  state.allocation = allocation;
  state.stopping = stopping;
  // A stop does not wait for the disk.
  return write_state(state,
                     [&](std::span<const std::byte> block) { return (ended || !stop_requested) && sink(block); });
}

RenderProgress RenderSession::Render::report() {
  measure_stopped();
  const std::lock_guard lock(mutex);
  RenderProgress p = progress;
  if (p.state == SessionState::rendering || p.state == SessionState::paused) p.wall_seconds = seconds_rendered();
  p.covered = film && film->is_covered();
  p.samples_total = std::max(p.samples_total, p.samples_done);
  if (p.samples_total > 0) p.fraction = static_cast<double>(p.samples_done) / static_cast<double>(p.samples_total);
  const double end = time_limit + (p.samples_done < p.pixels ? kFirstSampleGrace : 0);
  if (time_limit > 0) p.fraction = std::max(p.fraction, p.wall_seconds / end);
  p.fraction = p.state == SessionState::finished ? 1.0 : std::min(p.fraction, 1.0);
  return p;
}

}  // namespace alabaster
