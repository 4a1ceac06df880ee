// The primitives of a glTF mesh that are one surface, split by materials.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "delegate/api/types.h"

namespace alabaster::hd::gltf {

/// The triangles of a primitive.
struct SurfacePiece {
  std::string key;                         // pieces of different keys are never one surface
  const std::vector<Vec3f>* points;        // at rest
  const std::vector<uint32_t>* triangles;  // three points each
};

/// For each piece the first piece of its surface. Two pieces are one surface if an open edge of each lies at the same
/// positions, to the bit: an edge is open if one triangle of its piece has it. So pieces that are closed alone (a
/// liquid in its glass) stay apart, and their walks and interiors with them. Time and memory: the triangles', times the
/// logarithm of their number.
std::vector<size_t> surfaces_of(const std::vector<SurfacePiece>& pieces);

/// The triangles of a primitive whose positions were rounded to a grid of its own.
struct RoundedPiece {
  std::vector<Vec3f>* points;
  const std::vector<uint32_t>* triangles;
  float step;  // of the grid
};

/// Moves the ends of open edges onto those of an earlier piece that rounding can have parted, so that surfaces_of()
/// finds one surface. Its time and memory grow as those of surfaces_of().
void join_seams(const std::vector<RoundedPiece>& pieces);

}  // namespace alabaster::hd::gltf
