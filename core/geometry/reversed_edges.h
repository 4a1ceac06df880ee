// Edges at which the faces of a mesh do not wind alike.
#pragma once

#include "core/geometry/mesh.h"

namespace alabaster {

/// The edges, after welding, that their faces run along more often in one direction than in the other: some of the
/// faces there are turned against the others. Edges of an odd number of faces do not count, which are open.
OpenEdges::Kind find_reversed_edges(const Mesh& mesh);

}  // namespace alabaster
