// Camera samples one at a time, without session and film, for tests of the integrator.
#pragma once

#include <memory>
#include <utility>

#include "core/integrator/camera_interiors.h"
#include "core/integrator/path_integrator.h"
#include "testenv/support/scene_builder.h"
#include "testenv/support/statistics.h"

namespace alabaster::testing {

/// The camera stands at `eye` and looks at `target`.
class PathTracer {
 public:
  PathTracer(std::shared_ptr<const SceneSnapshot> scene, const Vec3d& eye, const Vec3d& target = {0, 0, 0})
      : scene_(std::move(scene)),
        camera_(look_at(eye, target, 30), 1, 1, scene_->origin),
        camera_interiors_(
            CameraInteriors::find({*scene_, camera_, settings, counters}, camera_.ray_origins({0, 0}, {1, 1}))) {}

  IntegratorSettings settings = integrator_settings({});
  AovSet aovs = aov_bit(Aov::color);
  RenderCounters counters;
  float reach = std::numeric_limits<float>::infinity();  // of the camera's rays

  PathContext context(LightLayers* layers = nullptr) {
    PathContext context{*scene_, camera_, settings, counters, layers, aovs};
    context.camera_interiors = camera_interiors_.get();
    return context;
  }
  /// Sample `index` of the only pixel, through its centre. Fills `layers` unless null.
  FilmSample trace(uint32_t index, LightLayers* layers = nullptr) {
    Ray ray = camera_.generate_ray({0.5f, 0.5f}, {0, 0});
    ray.tmax = reach;
    return trace_path(context(layers), ray, PixelSampler(run_seed(kPixelSeed), index));
  }

 private:
  static constexpr uint32_t kPixelSeed = 20;
  std::shared_ptr<const SceneSnapshot> scene_;
  Camera camera_;
  std::unique_ptr<const CameraInteriors> camera_interiors_;
};

/// Lambert's term of the BSDF and nothing else: f = (color / pi) (1 - .5 F_L) (1 - .5 F_V).
inline DisneyParameters matt(const Rgb& color) {
  DisneyParameters p;
  p.base_color = color;
  p.roughness = 0;  // no retro-reflection
  p.ior = 1;        // no specular
  p.specular = 0;
  return p;
}

}  // namespace alabaster::testing
