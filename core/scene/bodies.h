// The plan of subsurface bodies: the instances that let light below their surface, and the others with which each does
// so as one body.
#pragma once

#include "core/scene/scene.h"

namespace alabaster {

/// The descriptions of snapshot->instances, and of the looks of snapshot->arrays, in their order.
struct DrawnInstances {
  const std::vector<const InstanceDescription*>&alone, &looks;
};

/// True if each instance of an array with this look is a body by itself, which needs no BVH of its own, or no body.
bool scatter_separately(const InstanceDescription& look, const CancelToken& cancel);

struct BodySources {
  const DrawnInstances drawn;
  const std::shared_ptr<TraceDevice>& device;
  const SceneSnapshot* last;  // unions that it has as well share its BVHs; may be null
  const CancelToken& cancel;
};

/// Makes the bodies of the instances that scatter, with their media and the shortcuts that pay, and counts the bodies'
/// memory, but for the interiors of meshes. False when Embree refuses (reported). Throws BuildCancelled and
/// std::bad_alloc.
bool plan_bodies(const BodySources& sources, SceneSnapshot* snapshot);

}  // namespace alabaster
