// A triangle mesh ready to trace, and how a cage becomes one.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/geometry/cage.h"
#include "core/math/bounds.h"

namespace alabaster {

/// Triangles wind counter-clockwise seen from outside (left_handed is already undone). Corner attributes are found
/// through `triangles` (per vertex) or `uv_triangles` when uvs are split along seams.
struct Mesh {
  std::vector<Vec3f> points;
  std::vector<std::array<uint32_t, 3>> triangles;
  std::vector<Vec3f> normals;                             // empty: flat
  std::vector<std::array<uint32_t, 3>> normal_triangles;  // empty: same as triangles
  std::vector<Vec2f> uvs;                                 // empty: none
  std::vector<std::array<uint32_t, 3>> uv_triangles;      // empty: same as triangles
  std::vector<int32_t> triangle_face;                     // face of the cage, which elementId reports
  std::vector<int32_t> triangle_material;                 // slot; empty: all 0
  Bounds bounds;
  bool closed = false;  // every edge is shared by an even number (>= 2) of triangles, after welding points by position

  /// The cage's face that a triangle is part of.
  int element(uint32_t triangle) const {
    return triangle_face.empty() ? static_cast<int>(triangle) : triangle_face[triangle];
  }
  size_t memory_bytes() const;
};

struct RefinementOptions {
  int level = 0;                          // 0..8; 0 draws the cage itself
  size_t memory_limit = size_t(2) << 30;  // bytes; the level is lowered (and reported) until the estimate fits
  std::string where;                      // for reports
};

/// Turns a sanitized cage into triangles. level > 0 with a scheme other than `none`: points and normals of the limit
/// surface, evaluated with OpenSubdiv Bfr on a uniform tessellation of 2^level segments per (regular) edge; points on
/// shared edges are evaluated once, so the result is watertight; face-varying uvs by the cage's rule. Otherwise the
/// faces are triangulated as they are: polygons without folding over for concave planar ones, smooth normals computed
/// for catmull_clark and loop without authored ones (area weighted), authored normals used, else flat.
Mesh build_mesh(const Cage& cage, const RefinementOptions& options, const DiagnosticSink& sink);

/// Bytes that build_mesh would need at this level (an upper estimate), without building it.
size_t estimate_mesh_bytes(const Cage& cage, int level);

/// Vertices at the same position become one where a file had to split them (uv seams): returns for each point the index
/// of the first point with the same bits (after -0 -> +0).
std::vector<int> weld_by_position(const std::vector<Vec3f>& points);

}  // namespace alabaster
