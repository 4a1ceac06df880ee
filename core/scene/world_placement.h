// Where instances stand in world space, before render space is chosen.
#pragma once

#include "core/math/bounds.h"
#include "core/math/transform.h"

namespace alabaster {

/// A box of object space at a transform.
BoundsDouble world_bounds(const Bounds& object, const Matrix4d& object_to_world);

/// False for a transform that is not finite or reaches beyond what can be traced. A singular one within reach hides an
/// instance or a light by a scale of zero, as animations do.
bool is_within_reach(const Matrix4d& m);
/// False for a box that reaches beyond what can be traced.
bool is_within_reach(const BoundsDouble& bounds);

/// To a space whose origin is there.
Matrix4d moved_to(Matrix4d m, const Vec3d& origin);

}  // namespace alabaster
