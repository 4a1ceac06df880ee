// The interiors of clear bodies in which the rays of a camera begin. They are found once for a render where they are
// the same for all rays.
#pragma once

#include <memory>
#include <optional>

#include "core/integrator/media.h"
#include "core/integrator/path_integrator.h"

namespace alabaster {

/// True if rays with these origins may begin behind a closed mesh that is there from its front alone: they pass it.
bool begin_behind_fronts(const SceneSnapshot& scene, const Bounds& origins);

/// Immutable: any number of threads may share one.
class CameraInteriors {
 public:
  /// `origins`: bounds of the origins of the camera's rays, render space (MovingCamera::ray_origins). `context` stands
  /// for any sample; its `camera_interiors` are not read. Null: all rays begin outside. Throws BuildCancelled.
  static std::unique_ptr<const CameraInteriors> find(const PathContext& context, const Bounds& origins);

  /// The interiors in which a ray of the camera begins.
  MediumStack of(const PathContext& context, const Ray& ray) const;

 private:
  std::optional<MediumStack> same_;  // of all rays; empty: each ray finds its own
};

}  // namespace alabaster
