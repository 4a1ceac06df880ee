// A triangle mesh ready to trace, and how a cage becomes one.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "core/geometry/cage.h"
#include "core/math/bounds.h"

namespace alabaster {

using Corners = std::array<uint32_t, 3>;

/// Values that are interpolated over triangles.
template <class T>
struct MeshAttribute {
  std::vector<T> values;           // empty: none
  std::vector<Corners> triangles;  // indices of values; empty: same as the mesh's triangles
  bool empty() const { return values.empty(); }
};

/// Compared by a hash of 64 bits (FNV-1a), because hits compare it. Names that share a hash share a uv set: a file that
/// is made so gets another set of its own.
class UvSetName {
 public:
  UvSetName(std::string text) : text_(std::move(text)) {
    for (const char c : text_) hash_ = (hash_ ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
  }
  UvSetName(const char* text) : UvSetName(std::string(text)) {}
  const std::string& text() const { return text_; }
  bool operator==(const UvSetName& other) const { return hash_ == other.hash_; }

 private:
  uint64_t hash_ = 0xcbf29ce484222325u;
  std::string text_;
};

struct UvSet : MeshAttribute<Vec2f> {
  UvSetName name = "st";
};

/// Triangles wind counter-clockwise seen from outside (left_handed is already undone).
struct Mesh {
  std::vector<Vec3f> points;
  std::vector<Corners> triangles;
  std::vector<Vec3f> normals;             // empty: flat
  std::vector<Corners> normal_triangles;  // empty: same as triangles
  MeshAttribute<Vec4f> tangents;          // authored: direction of u, and the sign of n x t along growing v
  std::vector<UvSet> uv_sets;             // the first gives a hit's uv and dpdu
  MeshAttribute<Rgb> colors;
  MeshAttribute<float> opacities;
  std::vector<int32_t> triangle_face;      // face of the cage, which elementId reports
  std::vector<int32_t> triangle_material;  // slot; empty: all 0
  Bounds bounds;
  bool closed = false;   // every edge is shared by an even number (>= 2) of triangles, after welding points by position
  bool outward = false;  // closed, and its triangles enclose a positive volume

  /// The cage's face that a triangle is part of.
  int element(uint32_t triangle) const {
    return triangle_face.empty() ? static_cast<int>(triangle) : triangle_face[triangle];
  }
  /// Null if there is none of that name.
  const UvSet* uv_set(const UvSetName& name) const;
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
