// FB_ngon_encoding: polygons written as triangle fans, so that a renderer that does not know them still draws them.
// A polygon is a run of triangles that share their first index and chain (each one's third is the next one's second).
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
  size_t dropped_faces = 0;         // had fewer than three different points
};

/// Polygons of a triangle list: how many triangles each takes, in order. Writers promise that neighbouring polygons
/// never share their first index, but some break it. Mostly such polygons do not chain, which tells them apart. Two
/// quads that do chain look like one hexagon: a run of four or more triangles counts as one polygon only if it is
/// convex, and is cut into quads otherwise. (Pentagons of real cages are often neither flat nor convex: they are
/// believed.)
std::vector<uint32_t> find_polygons(const std::vector<uint32_t>& triangles, const std::vector<Vec3f>& points);

/// Decodes the polygons of `triangles` and welds: vertices that were split for their normals or texture coordinates
/// become one point again. `st` is empty or one per point.
Cage build_cage(const std::vector<uint32_t>& triangles, const std::vector<Vec3f>& points, const std::vector<Vec2f>& st);

}  // namespace alabaster::hd::gltf
