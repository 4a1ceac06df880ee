// Where render space has its origin: single precision is finest there.
#pragma once

#include <span>
#include <vector>

#include "core/geometry/mesh.h"
#include "core/math/bounds.h"
#include "core/math/transform.h"

namespace alabaster {

/// The middle half of a mesh's points along each axis: a few stray points do not change it.
struct MiddleHalf {
  Vec3d center{0, 0, 0}, extent{0, 0, 0};
};
MiddleHalf middle_half(const Mesh& mesh);

/// The size of an instance, or of several that stand near each other.
struct PlacedSize {
  BoundsDouble centers;
  double size = 0;  // of the least
  size_t count = 1;
};
PlacedSize placed_size(const MiddleHalf& middle, const Matrix4d& object_to_world);

struct SceneOrigin {
  Vec3d origin{0, 0, 0};
  bool is_center = true;  // of the bounds, from which none is too far
  /// Indices of those that stand a million times their own size or more away from it, where floats no longer hold their
  /// shape.
  std::vector<size_t> too_far;
};

/// The centre of the scene's bounds (world). Where some instances would be too far from it, a place from which fewer
/// are: so a stray point of one mesh does not take the precision from all others. Scaling a scene by a power of two
/// scales the origin exactly.
SceneOrigin choose_origin(std::span<const PlacedSize> all, const BoundsDouble& bounds);

/// So many are too far away from `origin`.
size_t count_too_far(std::span<const PlacedSize> all, const Vec3d& origin);

}  // namespace alabaster
