// Where render space has its origin: single precision is finest there.
#pragma once

#include <span>
#include <vector>

#include "core/math/bounds.h"
#include "core/scene/scene.h"

namespace alabaster {

struct SceneOrigin {
  Vec3d origin{0, 0, 0};
  /// Those that stand a million times their own size or more away from it, where floats no longer hold their shape.
  std::vector<const InstanceDescription*> too_far;
};

/// The centre of the scene's bounds (world). Where some instances would be too far from it, a place from which fewer
/// are: so a stray point of one mesh does not take the precision from all others. Scaling a scene by a power of two
/// scales the origin exactly.
SceneOrigin choose_origin(std::span<const InstanceDescription* const> drawn, const BoundsDouble& bounds);

}  // namespace alabaster
