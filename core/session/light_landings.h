// Light that light paths bring to the samples of a frame (core/integrator/light_path.h). Each sample of the frame has
// light paths of its own, so that a pixel's sample stays a function of its address; in adaptive frames also of the
// sample of the frame during which it is taken, which the allocation determines (SampleAllocation::frame_sample()).
#pragma once

#include <array>
#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <vector>

#include "core/diagnostics/counters.h"
#include "core/film/film.h"
#include "core/film/filter.h"
#include "core/integrator/light_path.h"

namespace alabaster {

/// Light that a pixel gets: colour, and the part of it that its first surface reflects by its specular lobes.
struct LandedLight {
  Rgb color{0.0f}, specular{0.0f};
};

/// The landings of one sample of the frame.
class LandedSample {
 public:
  /// In the order of pixels; those of one pixel are added up in the order in which they come.
  struct Entry {
    int32_t x, y;
    LandedLight light;
  };
  /// `entries` are of pixels in `window`.
  LandedSample(const PixelRect& window, std::vector<Entry> entries);
  /// Null: the pixel gets nothing.
  const LandedLight* find(int x, int y) const;

 private:
  int y0_;
  std::vector<Entry> entries_;  // by y, then x
  std::vector<uint32_t> rows_;  // where each begins
};

class LightLandings;

/// The landings that a thread has asked for last.
class LandedCache {
 public:
  explicit LandedCache(LightLandings* landings) : landings_(landings) {}
  /// See LightLandings::of_sample.
  const LandedSample& of_sample(uint32_t sample, RenderCounters* counters);
  /// The rays of light paths that the thread has traced meanwhile. Which of its pixels asked for them first depends on
  /// the order of threads.
  uint64_t rays() const { return rays_; }

 private:
  struct Slot {
    uint32_t sample = ~0u;
    std::shared_ptr<const LandedSample> landed;
  };
  LightLandings* landings_;
  uint64_t rays_ = 0;
  std::array<Slot, 16> slots_;  // as many as a pass has samples
};

/// Everything that the light paths of a frame need to know.
struct LightLandingsRequest {
  const SceneSnapshot& scene;
  const Camera& camera;
  const IntegratorSettings& settings;
  int width, height;  // of the display window, for which light paths are counted
  PixelRect window;   // pixels outside it are not kept
  PixelFilter filter;
  uint32_t frame, seed;
  const CameraInteriors* camera_interiors = nullptr;  // PathContext's
};

/// Traces the light paths of a sample when a thread first asks for it, on all threads that ask for it meanwhile. Any
/// number of threads may share one.
class LightLandings {
 public:
  explicit LightLandings(const LightLandingsRequest& request) : request_(request) {}

  /// Null: camera paths of this sample find all light. Throws BuildCancelled.
  const LightPathPlan* plan(uint32_t sample);
  /// For samples that have a plan. Throws BuildCancelled.
  std::shared_ptr<const LandedSample> of_sample(uint32_t sample, RenderCounters* counters);

 private:
  struct Build;
  void make_plan();
  void trace_chunk(uint32_t sample, uint32_t chunk, RenderCounters* counters,
                   std::vector<LandedSample::Entry>* out) const;
  std::shared_ptr<Build> build_of(uint32_t sample);

  const LightLandingsRequest request_;
  std::mutex plan_lock_;
  std::atomic<bool> is_planned_{false};
  LightPathPlan plan_;
  std::mutex builds_lock_;
  std::vector<std::shared_ptr<Build>> builds_;  // of the samples asked for last
};

}  // namespace alabaster
