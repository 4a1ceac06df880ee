// The limit surface of a cage as triangles. Used by build_mesh.
#pragma once

#include <optional>

#include "core/geometry/mesh.h"

namespace alabaster {

/// Limit surface of a sanitized cage whose scheme is not `none`, tessellated with 2^level segments per regular edge,
/// level >= 1, or as many as options.segments asks for. Fills all of Mesh but bounds and closed. Nothing if OpenSubdiv
/// refuses the topology (reported).
std::optional<Mesh> tessellate_limit_surface(const Cage& cage, const RefinementOptions& options,
                                             const DiagnosticSink& sink);

/// Bytes of a refined mesh for each of its triangles, roughly and from above, with what it takes to test if it is
/// closed.
size_t bytes_per_triangle(const Cage& cage);
/// Has options.memory, if there is one, hold a mesh of so many triangles and bytes. Throws MemoryRefused.
void hold_mesh(const RefinementOptions& options, double triangles, double bytes);
/// The same with what the build takes beside it, and the least that tracing it will.
void hold_build(const RefinementOptions& options, double triangles, double bytes);

}  // namespace alabaster
