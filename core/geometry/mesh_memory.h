// The memory of meshes before they are built. Used by build_mesh; estimate_mesh_bytes is in mesh.h.
#pragma once

#include "core/geometry/mesh.h"

namespace alabaster {

size_t count_triangles(const Cage& cage, int level);
/// Bytes of a refined mesh for each of its triangles, roughly and from above, with what it takes to test if it is
/// closed.
size_t bytes_per_triangle(const Cage& cage);
/// Resizes the reservation options.memory, unless null, to `bytes` for a mesh of `triangles`. Throws MemoryRefused.
void hold_mesh(const RefinementOptions& options, double triangles, double bytes);
/// The same with what the build takes beside it, and the least that tracing it will.
void hold_build(const RefinementOptions& options, double triangles, double bytes);

}  // namespace alabaster
