// Authored normals and tangents that are of no use, replaced by computed ones. Internal to this room.
#pragma once

#include "core/geometry/mesh.h"

namespace alabaster {

struct MendedVectors {
  size_t count = 0;  // normals, or corners of triangles
  int element = 0;   // the cage's face of the first
};

/// True unless one is zero or not finite.
bool are_usable(const std::vector<Vec3f>& normals);

/// Zero normals and those that are not finite become the mean over the triangles that use them, weighted by area; zero
/// where these cancel.
MendedVectors mend_normals(Mesh* mesh);

/// The corners whose tangent is zero, not finite or along the normal, or has no sign.
MendedVectors find_unusable_tangents(const Mesh& mesh);

/// These corners get the tangents of compute_tangents() for the first uv set. Without a usable one, or without texture
/// coordinates, the mesh has none afterwards.
void mend_tangents(Mesh* mesh, size_t unusable);

}  // namespace alabaster
