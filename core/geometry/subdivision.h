// The limit surface of a cage as triangles. Used by build_mesh.
#pragma once

#include <optional>

#include "core/geometry/mesh.h"

namespace alabaster {

/// The highest level of a cage; 0 draws the cage itself.
inline constexpr int kMaxSubdivisionLevel = 8;

/// Limit surface of a sanitized cage whose scheme is not `none`, tessellated with 2^level segments per regular edge,
/// level >= 1, or as many as options.segments asks for. Fills all of Mesh but bounds and closed. Nothing if OpenSubdiv
/// refuses the topology (reported).
std::optional<Mesh> tessellate_limit_surface(const Cage& cage, const RefinementOptions& options,
                                             const DiagnosticSink& sink);

}  // namespace alabaster
