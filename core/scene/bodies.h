// The plan of subsurface bodies: the instances that let light below their surface, and the others with which each does
// so as one body.
#pragma once

#include "core/scene/scene.h"

namespace alabaster {

/// Makes the bodies of the instances that scatter, with their media and the shortcuts that pay, and counts the
/// bodies' memory, but for the interiors of meshes. `drawn` describes snapshot->instances, in their order. Unions that
/// `last` (may be null) has as well share its BVHs. False when memory runs out or Embree refuses (reported). Throws
/// BuildCancelled.
bool plan_bodies(const std::vector<const InstanceDescription*>& drawn, const std::shared_ptr<TraceDevice>& device,
                 const SceneSnapshot* last, SceneSnapshot* snapshot, const CancelToken& cancel);

}  // namespace alabaster
