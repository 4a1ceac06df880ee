// Which instances scatter, and with which others as one body.
#pragma once

#include "core/scene/scene.h"

namespace alabaster {

/// Prepares walks in the instances that have a scattering material: their shells, and the sets. `drawn` describes
/// snapshot->instances, in their order. False when memory runs out or Embree refuses (reported).
bool prepare_scattering(const std::vector<const InstanceDescription*>& drawn,
                        const std::shared_ptr<TraceDevice>& device, SceneSnapshot* snapshot);

}  // namespace alabaster
