// Vertices inside of a cage that have two faces only, as one in the middle of an edge: OpenSubdiv 3.5 and 3.6 fail at
// their faces. Used by the tessellator.
#pragma once

#include <opensubdiv/far/topologyLevel.h>

#include <optional>
#include <string>

#include "core/geometry/cage.h"

namespace alabaster {

/// True if a face meets one neighbour at two edges in a row. Bfr merges equal indices in the neighbourhood of such a
/// face, and the key of its cache does not see them: patches of other numbers of points have one key.
bool has_two_face_vertex(const OpenSubdiv::Far::TopologyLevel& base, int face);
bool any_has_two_face_vertex(const OpenSubdiv::Far::TopologyLevel& base);

/// True if a sharp or non-manifold edge inside of the surface ends at a corner of such a face: Bfr and Far then write
/// past the end of their arrays.
bool is_sharp_at_two_face_vertex(const OpenSubdiv::Far::TopologyLevel& base);

/// The cage without the creases at corners of such faces, which `message` then tells. Its face-varying values are each
/// of one point only, so that equal indices of different points are not taken for one value.
Cage cage_for_two_face_vertices(const Cage& cage, const OpenSubdiv::Far::TopologyLevel& base, std::string* message);

}  // namespace alabaster
