// Faces of a cage that lie on each other, as in meshes whose faces are doubled and reversed.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/geometry/cage.h"

namespace alabaster {

/// A face, and an earlier one with the same number of corners.
struct CoincidentFace {
  uint32_t face;
  size_t first_corner;  // of the earlier face, in face_vertex_indices
};

/// Candidates: the faces of four corners and more whose positions, in any order, have the hash of those of an earlier
/// face. cut_alike() compares the positions. In the order of the faces. Each refers to the first of its kind.
std::vector<CoincidentFace> find_coincident_faces(const Cage& cage);

/// The triangulation of a face, of corner indices, that covers the earlier one with the same triangles: those of
/// `earlier`, which are the earlier face's, for the face whose first corner is `first`. Empty: the corners do not
/// follow each other alike in either direction.
std::vector<std::array<int, 3>> cut_alike(const Cage& cage, const CoincidentFace& coincident, size_t first,
                                          const std::vector<std::array<int, 3>>& earlier);

}  // namespace alabaster
