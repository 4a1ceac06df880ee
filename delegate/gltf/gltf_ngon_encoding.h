// FB_ngon_encoding: polygons stored as triangle fans, which any renderer can draw. A polygon is a run of triangles that
// share their first index and are chained (the third index of each is the second of the next).
#pragma once

#include <cstdint>
#include <vector>

#include "delegate/api/types.h"

namespace alabaster::hd::gltf {

/// A control cage: vertices welded by position. Vertices are those of the triangles that it was made from.
struct Cage {
  std::vector<uint32_t> point_vertices;  // the vertex that each point is taken from
  std::vector<int32_t> vertex_points;    // the point that each vertex becomes
  std::vector<int32_t> face_vertex_counts, face_vertex_indices;
  std::vector<uint32_t> corner_vertices;  // per face vertex
  std::vector<size_t> part_ends;          // the number of faces up to the end of each part
  size_t dropped_faces = 0;               // polygons with fewer than three different points
};

/// Decodes the polygons of `triangles` and welds vertices that were split for their normals, texture coordinates or
/// materials. `ends` are those of parts, in `triangles`: no polygon lies in two.
Cage build_cage(const std::vector<uint32_t>& triangles, const std::vector<Vec3f>& points,
                const std::vector<size_t>& ends);

/// A face-varying primvar of a cage.
struct CornerValues {
  std::vector<uint32_t> vertices;  // whose values are taken, in order
  std::vector<int32_t> indices;    // per face vertex, into these
};
/// Equal values at one point become one value, so that only real seams are seams of the refined surface. `values` has
/// 1 to 4 components for each vertex.
CornerValues weld_corners(const Cage& cage, const std::vector<float>& values, size_t components);

}  // namespace alabaster::hd::gltf
