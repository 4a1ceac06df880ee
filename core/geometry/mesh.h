// A triangle mesh ready to trace, and how a cage becomes one.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "core/diagnostics/cancel.h"
#include "core/geometry/cage.h"
#include "core/math/bounds.h"
#include "core/math/motion.h"
#include "core/memory/memory_budget.h"

namespace alabaster {

using Corners = std::array<uint32_t, 3>;

/// Values that are interpolated over triangles.
template <class T>
struct MeshAttribute {
  std::vector<T> values;           // empty: none
  std::vector<Corners> triangles;  // indices of values; empty: same as the mesh's triangles
  bool empty() const { return values.empty(); }
};

/// The name of a uv set or a named primvar. Compared by a hash of 64 bits (FNV-1a), because hits compare it. Names that
/// share a hash share a uv set: a file that is made so gets another set of its own.
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

/// See NamedPrimvar.
struct NamedAttribute {
  std::variant<MeshAttribute<float>, MeshAttribute<Vec2f>, MeshAttribute<Vec3f>, MeshAttribute<Vec4f>> values;
  UvSetName name = "";
};

/// The shape of a mesh that deforms, at another time. As many points and normals as the mesh has.
struct MeshPose {
  std::vector<Vec3f> points, normals;
};

/// Triangles wind counter-clockwise seen from outside (left_handed is already undone).
struct Mesh {
  std::vector<Vec3f> points;
  std::vector<Corners> triangles;
  std::vector<Vec3f> normals;             // empty: flat
  std::vector<Corners> normal_triangles;  // empty: same as triangles
  MeshAttribute<Vec4f> tangents;          // authored: direction of u, and the sign of n x t along growing v
  std::vector<UvSet> uv_sets;             // the first gives a hit's uv and dpdu
  std::vector<NamedAttribute> primvars;
  std::vector<int32_t> triangle_face;      // face of the cage, which elementId reports
  std::vector<int32_t> triangle_material;  // slot; empty: all 0
  /// Empty unless the mesh deforms. Points and normals are then those at the shutter's opening, and these follow at
  /// even times up to its close. Everything else that is said of the mesh's shape holds at the opening.
  std::vector<MeshPose> later_poses;
  Bounds bounds;         // at all times
  bool closed = false;   // every edge is shared by an even number (>= 2) of triangles, after welding points by position
  bool sealed = false;   // closed without welding, so whatever its points are
  bool outward = false;  // closed, and its triangles enclose a positive volume

  /// The cage's face that a triangle is part of.
  int element(uint32_t triangle) const {
    return triangle_face.empty() ? static_cast<int>(triangle) : triangle_face[triangle];
  }
  bool deforms() const { return !later_poses.empty(); }
  const std::vector<Vec3f>& points_of_pose(size_t i) const { return i == 0 ? points : later_poses[i - 1].points; }
  const std::vector<Vec3f>& normals_of_pose(size_t i) const { return i == 0 ? normals : later_poses[i - 1].normals; }
  /// A point or a normal, not unit, of a mesh that deforms.
  Vec3f point_at(uint32_t i, float time) const {
    const PoseTime at(time, later_poses.size() + 1);
    return at.between(points_of_pose(at.first)[i], later_poses[at.first].points[i]);
  }
  Vec3f normal_at(uint32_t i, float time) const {
    const PoseTime at(time, later_poses.size() + 1);
    return at.between(normals_of_pose(at.first)[i], later_poses[at.first].normals[i]);
  }
  /// The corners of a triangle at a time.
  std::array<Vec3f, 3> corners_at(uint32_t triangle, float time) const {
    if (deforms()) [[unlikely]]
      return posed_corners(triangle, time);
    const Corners& c = triangles[triangle];
    return {points[c[0]], points[c[1]], points[c[2]]};
  }
  /// Null if there is none of that name.
  const UvSet* uv_set(const UvSetName& name) const;
  const NamedAttribute* primvar(const UvSetName& name) const;
  size_t memory_bytes() const;

 private:
  std::array<Vec3f, 3> posed_corners(uint32_t triangle, float time) const;
};

struct RefinementOptions {
  int level = 0;      // 0..8; 0 draws the cage itself
  std::string where;  // for reports
  /// Holds what build_mesh() takes at most, by arithmetic, before it does (MemoryRefused), and in the end what the mesh
  /// keeps. Null: nobody counts.
  MemoryReservation* memory = nullptr;
  /// Adaptive refinement: how many segments a straight piece of the limit surface from a to b asks for. An edge of the
  /// cage gets the sum over its limit curve, rounded up, 256 at most. Asked on any thread. Empty: 2^level for each.
  std::function<float(const Vec3f& a, const Vec3f& b)> segments;
  std::function<void(Mesh*)> displace;  // moves the points of the finished surface; empty: none
  const Mesh* before = nullptr;         // of the same cage with other points, mostly; null: there is none
  CancelToken cancel = {};              // build_mesh() and pose_mesh() throw BuildCancelled
};

/// Turns a sanitized cage into triangles. level > 0 with a scheme other than `none`: points and normals of the limit
/// surface, evaluated with OpenSubdiv Bfr on a uniform tessellation of 2^level segments per (regular) edge; points on
/// shared edges are evaluated once, so the result is watertight, also where edges are refined adaptively; face-varying
/// uvs by the cage's rule. Otherwise the faces are triangulated as they are: polygons without folding over for concave
/// planar ones, smooth normals computed for catmull_clark and loop without authored ones (area weighted), authored
/// normals used, else flat.
Mesh build_mesh(const Cage& cage, const RefinementOptions& options, const DiagnosticSink& sink);

/// The shape of a mesh, which build_mesh() made of `cage` with these options, when the cage's points (and normals, if
/// it has authored ones) are these. As many of them as the cage has. Not for adaptive refinement.
MeshPose pose_mesh(const Cage& cage, const RefinementOptions& options, MeshPose posed);

/// Bytes that build_mesh takes at most at this level (an upper estimate), without building it.
size_t estimate_mesh_bytes(const Cage& cage, int level);

/// Vertices at the same position become one where a file had to split them (uv seams): returns for each point the index
/// of the first point with the same bits (after -0 -> +0).
std::vector<int> weld_by_position(const std::vector<Vec3f>& points, const CancelToken& cancel = {});

/// The edges for which a mesh is not closed, after welding.
struct OpenEdges {
  struct Kind {
    size_t count = 0;
    std::array<Vec3f, 2> first{};  // the ends of one of them
  };
  Kind of_one, of_more;  // with one triangle; with three or another odd number
};
OpenEdges find_open_edges(const Mesh& mesh);

}  // namespace alabaster
