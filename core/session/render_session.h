// One running render: threads, passes, pause, stop.
//
//   Idle --start--> Rendering --all samples, and denoised--> Finished
//                   Rendering <--pause/resume--> Paused
//                   Rendering/Paused --stop--> Stopped
//                   Rendering --out of memory or another exception--> Failed (RenderProgress::error says what)
// start() from any state stops and replaces the render that runs. Nothing is rendered in the caller's thread. It waits
// for the last render only where the next one continues it.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>

#include "core/convergence/frame_error.h"
#include "core/diagnostics/counters.h"
#include "core/film/film.h"
#include "core/session/deferred_notifier.h"
#include "core/session/render_request.h"

namespace alabaster {

enum class SessionState { idle, rendering, paused, stopped, finished, failed };

/// The cause of the end of a render that is over.
enum class RenderEnd { none, samples, target_error, time_limit };

struct RenderProgress {
  SessionState state = SessionState::idle;
  uint64_t scene_number = 0;
  uint64_t pixels = 0;
  uint64_t samples_done = 0;   // camera samples, over the whole frame
  uint64_t samples_total = 0;  // a prediction where target_error or time_limit may end the render
  double fraction = 0;         // of the work, 0..1
  /// Passes that all tiles have finished. Every pixel has at least as many samples, unless target_error has ended its
  /// group of pixels before.
  uint32_t passes_done = 0;
  bool covered = false;                // every part of the frame shows this render's samples, if in blocks
  uint64_t pixels_without_sample = 0;  // of a render that has ended: a stop or time_limit may leave some
  double wall_seconds = 0;
  double cpu_seconds = 0;      // of the render workers
  RenderCounters counters;     // of the finished tiles
  FrameError noise;            // measured after a pilot, at each check of target_error, when asked for, and at the end
  uint64_t noise_samples = 0;  // samples_done when it was measured
  double target_error = 0;     // of the settings; 0: none
  double groups_over_frame = 0;  // the error of groups of pixels (GroupStopping::error()) over `noise`; 0: none
  RenderEnd ended_by = RenderEnd::none;
  double denoised = -1;                        // share of the denoiser's work that is done; < 0: not begun
  double denoise_seconds = 0;                  // wall time of it; wall_seconds includes it, unless it came after a stop
  double denoise_cpu_seconds = 0;              // of the whole process meanwhile; not in cpu_seconds
  std::string denoiser;                        // Denoiser::name(), once AOV `denoised` shows its picture
  std::string denoise_error;                   // why AOV `denoised` is color still
  std::string error;                           // of a failed render
  std::optional<SampleAddress> failed_sample;  // the sample that failed a check, if one did
};

/// Parts of the owner that a session calls.
struct SessionOwner {
  /// Called on the driver's thread whenever the session may have released a snapshot; must not throw.
  std::function<void()> released = {};
  /// Render threads poll it. Null: none.
  std::shared_ptr<DeferredNotifier> notifier = {};
};

class RenderSession {
 public:
  explicit RenderSession(SessionOwner owner = {});
  ~RenderSession();  // stops
  RenderSession(const RenderSession&) = delete;
  RenderSession& operator=(const RenderSession&) = delete;

  void start(const RenderRequest& request);
  void pause();
  void resume();
  /// Blocks until no worker runs, for less than 20 ms. A denoiser ends after the step that it is at, one of thirty for
  /// each of its images: on two cores 0.2 s at 960 x 640, and about a second at 4 megapixels or more. Keeps the film.
  void stop();
  /// Denoises the film of a stopped render in the calling thread, if it asks for AOV `denoised`. Else, and for a film
  /// of another render, does nothing.
  void denoise_stopped(const Film* film);
  /// Blocks until no more is rendered, or `seconds` have passed; true: no more is rendered. Infinity waits without
  /// limit; a negative time and NaN do not wait.
  bool wait(double seconds);

  /// The noise of the running render is measured once more, at the end of a pass. A render thread does that, in a
  /// twentieth of its time at most, so it may be a later pass. Without a call no noise is measured there.
  void ask_for_noise();

  /// Writes the state of the render, from which another one may continue (RenderRequest::resumed), while workers
  /// render. Decisions wait for it, a stop does not. False: the sink refused, a stop came, or there is nothing to
  /// continue: no render, or one that failed.
  bool save(const BlockSink& sink);

  RenderProgress progress() const;  // never waits for workers
  /// The film of the current or last render; null before the first start.
  std::shared_ptr<const Film> film() const;

 private:
  struct Render;
  class Driver;
  /// True if the samples of a render that has ended are the first samples of `next`.
  static bool can_continue(const RenderRequest& last, const RenderRequest& next);
  std::shared_ptr<Render> current() const;

  const std::shared_ptr<DeferredNotifier> notifier_;
  mutable std::mutex mutex_;
  std::shared_ptr<Render> current_;  // never null
  std::unique_ptr<Driver> driver_;
};

}  // namespace alabaster
