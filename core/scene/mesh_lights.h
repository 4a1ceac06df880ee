// Instances that emit, as lights.
#pragma once

#include "core/scene/scene.h"

namespace alabaster {

/// True if some triangle has a material that emits.
bool emits(const Instance& instance);

/// The emissive triangles of an instance that emits and stands still, in render space. `index`: of the instance. Throws
/// BuildCancelled.
MeshLight make_mesh_light(const Instance& instance, uint32_t index, const CancelToken& cancel);

/// True if both emit alike at the same place: a light of one is that of the other, but for its index.
bool emit_alike(const Instance& a, const Instance& b);

}  // namespace alabaster
