// The limit surface of a cage as triangles. Used by build_mesh.
#pragma once

#include <optional>

#include "core/geometry/mesh.h"

namespace alabaster {

/// Limit surface of a sanitized cage whose scheme is not `none`, tessellated with 2^level segments per regular edge;
/// level >= 1. Fills all of Mesh but bounds and closed. Nothing if OpenSubdiv refuses the topology (reported).
std::optional<Mesh> tessellate_limit_surface(const Cage& cage, int level, const std::string& where,
                                             const DiagnosticSink& sink);

}  // namespace alabaster
