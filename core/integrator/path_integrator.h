// Path tracing with next-event estimation, multiple importance sampling and subsurface walks. Unbiased but for
// max_depth, textureFilter, glossyFilter, walk_sphere_steps, and the subsurface modes diffusion and lambert.
#pragma once

#include "core/camera/camera.h"
#include "core/diagnostics/counters.h"
#include "core/film/film.h"
#include "core/material/energy_model.h"
#include "core/sampling/pixel_sampler.h"
#include "core/scene/scene.h"
#include "core/subsurface/random_walk.h"

namespace alabaster {

/// Raised where equal scenes, settings and seeds no longer give equal samples: sums of different samples cannot be
/// parts of one picture.
inline constexpr int kSamplingVersion = 16;

enum class SubsurfaceMode {
  lambert,    // scatter distances are taken as zero: the 2015 diffuse
  walk,       // path-traced random walk, with the shortcuts that pay
  reference,  // the walk without any shortcut: the yardstick
  diffusion,  // Burley's profile over the distance between entry and exit
};

/// The part of a render's settings that paths read. core/session/render_settings.h has the defaults.
struct IntegratorSettings {
  uint32_t max_depth;  // bounces between surfaces; 1 = direct light only; a subsurface walk counts as one
  SubsurfaceMode subsurface;
  AlbedoInversion inversion;
  WalkSettings walk;
  EnergyModel energy = EnergyModel::bounded;
  float texture_filter = 0;              // of colour textures, in widths of a path's footprint; 0: none
  float glossy_filter = 0;               // see Footprint::least_alpha; 0: none
  float ambient_occlusion_distance = 0;  // of what occludes; 0: any
};

class CameraInteriors;
class PathRecord;

/// The vectors of the first hit that AOVs show (kVectorAovs), and what they are measured by.
struct HitVectorRequest {
  const std::vector<UvSetName>& primvars;  // by their AOVs
  const Camera &opens, &closes;  // where the camera stands when the time that AOV motion shows begins and ends
  bool at_ends;                  // and surfaces where Instance::ends says; else by the times
  float open_time, close_time;   // of the scene's shutter
  HitVectors* out;
};

/// Everything a path needs to know; lives on the worker's stack.
struct PathContext {
  const SceneSnapshot& scene;
  const Camera& camera;
  const IntegratorSettings& settings;
  RenderCounters& counters;
  LightLayers* layers = nullptr;              // of the sample; null: not asked for
  AovSet aovs = aov_bit(Aov::color);          // values of the first hit are computed only for these
  PathRecord* record = nullptr;               // the path is written here
  float time = 0;                             // of the shutter; all rays have it. `camera` stands as it does then
  const HitVectorRequest* vectors = nullptr;  // null: no AOV shows them
  const MaterialNumbers::element_type* materials = nullptr;  // the same
  const InstanceMattes::element_type* mattes = nullptr;      // null: each prim has one
  const CameraInteriors* camera_interiors = nullptr;         // null: camera rays begin outside of clear bodies
  bool begins_behind_fronts = false;                         // camera rays do: begin_behind_fronts()
  LightByGroup* light_groups = nullptr;                      // of the sample; null: not asked for
  /// How walks go: `reference` differs from `walk` in its settings.
  SubsurfaceMode mode() const {
    if (!scene.features.subsurface) return SubsurfaceMode::lambert;
    return settings.subsurface == SubsurfaceMode::reference ? SubsurfaceMode::walk : settings.subsurface;
  }
  /// True if rays of paths may pass surfaces.
  bool sees_through() const { return scene.features.see_through || begins_behind_fronts; }
};

/// Traces one camera sample. `camera_ray`: unit direction, render space, at the context's time. Color and alpha are the
/// same to the bit whatever else is asked for.
FilmSample trace_path(const PathContext& context, const Ray& camera_ray, const PixelSampler& sampler);

}  // namespace alabaster
