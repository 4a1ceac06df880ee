// One running render: threads, passes, pause, stop.
//
//   Idle --start--> Rendering --all samples--> Finished
//                   Rendering <--pause/resume--> Paused
//                   Rendering/Paused --stop--> Stopped
//                   Rendering --out of memory or another exception--> Failed (RenderProgress::error says what)
// start() from any state replaces what was running. Nothing renders in the caller's thread.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>

#include "core/camera/camera.h"
#include "core/diagnostics/counters.h"
#include "core/film/film.h"
#include "core/film/filter.h"
#include "core/convergence/frame_error.h"
#include "core/integrator/path_integrator.h"
#include "core/scene/scene.h"

namespace alabaster {

/// Names, ranges and defaults: schemas/render_settings.json (a test compares).
struct RenderSettings {
  uint32_t samples = 64;   // per pixel, at most; with `adaptive` the mean over pixels
  float target_error = 0;  // relative RMSE (core/convergence/frame_error.h) at which the render ends; 0: it is not asked
  bool adaptive = false;   // deals the samples out by where the noise is (core/convergence/sample_allocation.h)
  float time_limit = 0;    // seconds from start() after which it ends, two samples per pixel at least; 0: none
  uint32_t seed = 0;
  uint32_t frame = 0;
  uint32_t max_depth = 8;       // bounces between surfaces; a subsurface walk counts as one
  uint32_t roulette_depth = 3;  // bounces after which roulette may end a path: noise and time, no bias
  uint32_t threads = 0;         // 0: all
  SubsurfaceMode subsurface = SubsurfaceMode::walk;
  AlbedoInversion inversion = AlbedoInversion::exact;
  WalkWeights walk_weights = WalkWeights::throughput;
  bool walk_guiding = true;
  bool walk_sphere_steps = true;
  PixelFilter filter = PixelFilter::blackman_harris;
  bool operator==(const RenderSettings&) const = default;
};

struct RenderRequest {
  std::shared_ptr<const SceneSnapshot> scene;
  CameraParameters camera;
  int width = 0, height = 0;  // display window: what the camera is framed to
  PixelRect data_window;      // pixels to render; may be a crop of, or larger than (overscan), the display window
  uint32_t aovs = aov_bit(Aov::color);
  RenderSettings settings;
};

enum class SessionState { idle, rendering, paused, stopped, finished, failed };

struct RenderProgress {
  SessionState state = SessionState::idle;
  uint64_t scene_number = 0;
  uint64_t pixels = 0;
  uint64_t samples_done = 0, samples_total = 0;  // camera samples of the whole frame; the total is a prediction where
                                                 // an error or a time decides
  double fraction = 0;                           // of the work that is done, 0..1
  uint32_t passes_done = 0;                      // whole passes: every pixel has at least this many samples
  double wall_seconds = 0;
  double cpu_seconds = 0;   // of the render workers
  RenderCounters counters;  // as of the last finished tile
  FrameError noise;   // if it was asked: as of the last time that it was looked at, at the end or where it decides
  std::string error;  // of a failed render
};

class RenderSession {
 public:
  RenderSession();
  ~RenderSession();  // stops
  RenderSession(const RenderSession&) = delete;
  RenderSession& operator=(const RenderSession&) = delete;

  void start(const RenderRequest& request);
  void pause();
  void resume();
  /// Blocks until no worker runs: below 20 ms. Keeps the film.
  void stop();
  /// Blocks until finished or stopped, or `seconds` have passed; returns whether it is over.
  bool wait(double seconds);

  RenderProgress progress() const;  // never blocks on workers
  /// The film of the current or last render; null before the first start.
  std::shared_ptr<const Film> film() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace alabaster
