// How to render: settings as plain values, in the units named below. The initialisers are the defaults, and
// setting_parameters() has names and ranges: a value that is set by its name is clamped to its range.
#pragma once

#include <cstdint>
#include <span>

#include "core/film/filter.h"
#include "core/integrator/path_integrator.h"
#include "core/parameter/parameter.h"

namespace alabaster {

/// The time over which AOV motion shows how things move.
enum class MotionShutter {
  frame,   // from the frame that is drawn to the next one
  camera,  // while the camera's shutter is open
};

/// How to render. Names and ranges: setting_parameters(). Meanings: schemas/render_settings.json.
struct RenderSettings {
  uint32_t samples = 64;  // per pixel, at most; with `adaptive` the mean over pixels
  uint32_t first_sample =
      0;                   // samples before it are left to other renders; 0 with target_error, adaptive or time_limit
  float target_error = 0;  // the render ends at this relative RMSE (core/convergence/frame_error.h); 0: no target
  bool adaptive = false;   // more samples go where there is more noise (core/convergence/sample_allocation.h)
  float time_limit = 0;    // seconds from start() to the last sample, without pauses; 0: no limit
  uint32_t seed = 0;
  uint32_t frame = 0;
  uint32_t max_depth = 8;  // bounces between surfaces; a subsurface walk counts as one
  uint32_t threads = 0;    // 0: all
  SubsurfaceMode subsurface = SubsurfaceMode::walk;
  AlbedoInversion inversion = AlbedoInversion::exact;
  bool walk_guiding = WalkSettings().guiding;
  bool walk_sphere_steps = WalkSettings().sphere_steps;
  uint32_t texture_memory = 4096;  // MiB of texels in memory (core/texture/texel_store.h); read by who loads textures
  uint32_t memory_limit = 0;       // MiB (core/memory/memory_budget.h), read by who makes the budget; 0: it chooses
  EnergyModel energy = EnergyModel::bounded;
  float texture_filter = 0;                             // see IntegratorSettings; above 0 it blurs
  float glossy_filter = 0;                              // see IntegratorSettings; above 0 it blurs
  float ambient_occlusion_distance = 0;                 // world units; 0: any
  MotionShutter motion_shutter = MotionShutter::frame;  // read by who describes the scene and the camera
  PixelFilter filter = PixelFilter::blackman_harris;
  float refine_edge_length =
      0;  // pixels: refined meshes get edges as long as this in the picture; 0: by their refineLevel
  uint32_t crypto_ranks = 6;  // read by who writes files: films keep all ids
  bool denoise = false;       // read by who binds AOVs: paths and films never depend on it
  bool operator==(const RenderSettings&) const = default;
};

/// The effect of a change of a setting on a render that runs; none of these: it starts again.
namespace setting_use {
inline constexpr uint32_t kContinues = 1;  // continues with its samples, where RenderSession::can_continue() is true
inline constexpr uint32_t kLive = 2;       // takes effect without a render
inline constexpr uint32_t kResyncs = 4;    // meshes are refined again
inline constexpr uint32_t kNoPixels = 8;   // samples do not depend on it, so that checkpoints may differ in it
}  // namespace setting_use

using SettingParameter =
    Parameter<RenderSettings, SubsurfaceMode, AlbedoInversion, EnergyModel, PixelFilter, MotionShutter>;
/// schemas/render_settings.json.
std::span<const SettingParameter> setting_parameters();

/// The reference mode takes no shortcut, whatever the settings of walks say.
IntegratorSettings integrator_settings(const RenderSettings& settings);

}  // namespace alabaster
