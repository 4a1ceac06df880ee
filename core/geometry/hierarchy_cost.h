// How well a hierarchy over a mesh's triangles still fits when their points have moved.
#pragma once

#include <cstdint>
#include <vector>

#include "core/geometry/mesh.h"

namespace alabaster {

/// Neighbouring triangles in groups of 8, these in groups of 8, and so on, by where they are in one mesh: as a
/// hierarchy would have them that was built for it.
class TriangleGroups {
 public:
  /// Throws BuildCancelled.
  explicit TriangleGroups(const Mesh& mesh, const CancelToken& cancel = {});
  /// The surfaces of the groups' boxes beside that of the whole, when the same triangles have other points: so many
  /// boxes a ray that meets the whole can expect to meet (Goldsmith and Salmon 1987). The same for any number of
  /// threads.
  double cost(const Mesh& mesh) const;

 private:
  std::vector<uint32_t> order_;  // of the triangles
};

}  // namespace alabaster
