// FB_ngon_encoding: polygons stored as triangle fans, which any renderer can draw. A polygon is a run of triangles that
// share their first index and are chained (the third index of each is the second of the next).
#pragma once

#include <cstdint>
#include <vector>

#include "delegate/api/types.h"

namespace alabaster::hd::gltf {

/// A control cage: points welded by position, texture coordinates face-varying.
struct Cage {
  std::vector<Vec3f> points;
  std::vector<int32_t> face_vertex_counts, face_vertex_indices;
  std::vector<Vec2f> st;            // empty: none
  std::vector<int32_t> st_indices;  // per face vertex
  size_t dropped_faces = 0;         // polygons with fewer than three different points
};

/// The number of triangles of each polygon in a triangle list, in order. Exporters promise that consecutive polygons do
/// not share their first index, but some break the promise. Most such polygons are not chained, which separates them.
/// Two quads that are chained look like a hexagon, so a run of four or more triangles counts as one polygon only if it
/// is convex, and is cut into quads otherwise. (Runs of three are never cut: pentagons of real cages are often neither
/// flat nor convex.)
std::vector<uint32_t> find_polygons(const std::vector<uint32_t>& triangles, const std::vector<Vec3f>& points);

/// Decodes the polygons of `triangles` and welds vertices that were split for their normals or texture coordinates.
/// `st` is empty or has one value per point.
Cage build_cage(const std::vector<uint32_t>& triangles, const std::vector<Vec3f>& points, const std::vector<Vec2f>& st);

}  // namespace alabaster::hd::gltf
