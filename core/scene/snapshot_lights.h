// The lights of a snapshot: those of the description and the meshes that emit, and which of them light and are
// shadowed by what.
#pragma once

#include "core/diagnostics/cancel.h"
#include "core/scene/bodies.h"
#include "core/scene/scene.h"

namespace alabaster {

struct LightSources {
  const SceneDescription& description;
  const DrawnInstances drawn;
  const SceneSnapshot* last;  // densities of images and emissive meshes that it has as well are shared; may be null
  bool described_alike;       // the description's lights and categories are those of `last`
  const std::shared_ptr<TraceDevice>& device;
  const DiagnosticSink& sink;
  const CancelToken& cancel;
};

/// Fills in the lights, their links and the features that they make, once the instances are placed. True if all lights
/// are those of `last`. Throws BuildCancelled and std::bad_alloc.
bool add_lights(const LightSources& sources, SceneSnapshot* snapshot);

}  // namespace alabaster
