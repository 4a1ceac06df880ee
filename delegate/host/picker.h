// Finds the prims, instances and faces that a rectangle of the picture shows, by the id AOVs.
#pragma once

#include "delegate/host/render_index.h"

namespace alabaster::hd::host {

/// An instance, as its instancer counts.
struct PickedInstance {
  Path instancer;
  int32_t index = 0;  // into the instancer's primvars
  bool operator==(const PickedInstance&) const = default;
};

/// A face of an instance of a mesh.
struct PickHit {
  Path path;                              // of the mesh
  int32_t instanceId = 0;                 // as AOV instanceId counts: all instances of the mesh, innermost fastest
  std::vector<PickedInstance> instances;  // the mesh's instancer first, then the one that places it, ...
  int32_t face = -1;                      // as the topology counts; -1: elementId is not bound
  int x = 0, y = 0;                       // the pixel nearest to the middle of the rectangle that shows it
  bool operator==(const PickHit&) const = default;
};

/// Each face that `rect` shows (pixels of the buffers, y-down) once, those nearest to its middle first: the first one
/// is that under a cursor. Read from the buffers that `state` binds to the AOVs primId, instanceId and elementId, of
/// format int32 and one size; without instanceId all hits are of instance 0. While samples are still added, the ids of
/// a pixel may be of two samples for a moment. `scene` is the one whose prims `index` holds, as it was last synced.
/// Empty if nothing is there, or primId is not bound. Host thread.
ALABASTER_API std::vector<PickHit> Pick(const RenderIndex& index, SceneDelegate& scene, const RenderPassState& state,
                                        const Rect2i& rect);

}  // namespace alabaster::hd::host
