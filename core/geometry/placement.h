// Where an instance stands.
#pragma once

#include "core/math/transform.h"

namespace alabaster {

/// Object space to render space, and back.
struct Placement {
  Affine object_to_world;
  Affine world_to_object;
};

}  // namespace alabaster
