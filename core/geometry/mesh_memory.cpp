#include "core/geometry/mesh_memory.h"

#include <algorithm>

#include "core/geometry/subdivision.h"

namespace alabaster {
namespace {

// Triangles and points that one face of n corners becomes at 2^level segments per edge (Bfr's patterns).
struct FaceSize {
  size_t triangles, points;  // points: interior and half of the boundary is shared, so counted without it
};

FaceSize tessellated_face(const Cage& cage, size_t corners, int level) {
  if (level == 0 || cage.scheme == SubdivisionScheme::none) return {corners - 2, 0};
  const size_t segments = size_t(1) << level;
  if (cage.scheme == SubdivisionScheme::loop) return {segments * segments, segments * segments / 2};
  if (corners == 4) return {2 * segments * segments, segments * segments};
  return {corners * segments * segments / 2, corners * segments * segments / 4 + 1};
}

// The primvars that are refined with the surface.
struct PrimvarBytes {
  size_t all = 0, face_varying = 0;  // of one value of each
  size_t seams = 0;                  // number of face-varying ones
};
PrimvarBytes primvar_bytes(const Cage& cage) {
  PrimvarBytes bytes;
  for_each_refined(cage, [&](const auto& primvar) {
    bytes.all += sizeof(primvar.values[0]);
    if (primvar.interpolation != Interpolation::face_varying) return;
    bytes.face_varying += sizeof(primvar.values[0]);
    ++bytes.seams;
  });
  return bytes;
}
// A triangle has its points, normals, face-varying primvars, face, slot, and the three edges that the test for
// closedness sorts by points, which it counts. At worst every face has its own normals along its boundary.
size_t index_bytes(const Cage& cage) {
  return (2 + primvar_bytes(cage).seams) * sizeof(Corners) + 2 * sizeof(int32_t) + 3 * sizeof(uint32_t);
}
constexpr size_t kPointBytes = sizeof(Vec3f) + sizeof(size_t);

}  // namespace

size_t count_triangles(const Cage& cage, int level) {
  size_t triangles = 0;
  for (const int count : cage.face_vertex_counts)
    triangles += tessellated_face(cage, static_cast<size_t>(count), level).triangles;
  return triangles;
}

size_t estimate_mesh_bytes(const Cage& cage, int level) {
  size_t triangles = 0, points = cage.points.size(), corners = 0;
  const size_t segments = size_t(1) << std::clamp(level, 0, kMaxSubdivisionLevel);
  for (int count : cage.face_vertex_counts) {
    const FaceSize face = tessellated_face(cage, static_cast<size_t>(count), level);
    triangles += face.triangles;
    points += face.points;
    corners += static_cast<size_t>(count);
  }
  const size_t boundary = corners * segments;  // samples on face boundaries, each face its own
  const PrimvarBytes primvars = primvar_bytes(cage);
  return points * kPointBytes + (points + boundary) * sizeof(Vec3f) + points * primvars.all +
         boundary * primvars.face_varying + triangles * index_bytes(cage);
}

size_t bytes_per_triangle(const Cage& cage) {
  return kPointBytes + sizeof(Vec3f) + primvar_bytes(cage).all + index_bytes(cage);
}

void hold_mesh(const RefinementOptions& options, double triangles, double bytes) {
  if (!options.memory) return;
  constexpr double kMost = 0x1p60;
  options.memory->resize(static_cast<size_t>(std::min(bytes, kMost)),
                         "a mesh of " + std::to_string(static_cast<size_t>(std::min(triangles, kMost))) + " triangles");
}

// Displacement sorts and sums over corners while it runs. A mesh is built to be traced: one that cannot be is refused
// before the work, and the tracer counts for itself what it takes then.
void hold_build(const RefinementOptions& options, double triangles, double bytes) {
  constexpr double kDisplacementBytes = 240, kTracingBytes = 100;  // of a triangle
  hold_mesh(options, triangles, bytes + triangles * (kTracingBytes + (options.displace ? kDisplacementBytes : 0)));
}

}  // namespace alabaster
