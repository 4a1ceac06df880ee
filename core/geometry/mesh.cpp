#include "core/geometry/mesh.h"

#include <tbb/parallel_sort.h>

#include <bit>
#include <cmath>
#include <cstring>

#include "core/geometry/coincident_faces.h"
#include "core/geometry/grouped_items.h"
#include "core/geometry/mend_vectors.h"
#include "core/geometry/mesh_memory.h"
#include "core/geometry/reversed_edges.h"
#include "core/geometry/shell_topology.h"
#include "core/geometry/subdivision.h"
#include "core/geometry/triangle_pairs.h"
#include "core/geometry/triangulation.h"

namespace alabaster {
namespace {

template <class T>
size_t bytes_of(const std::vector<T>& v) {
  return v.capacity() * sizeof(T);
}
template <class T>
size_t bytes_of(const MeshAttribute<T>& a) {
  return bytes_of(a.values) + bytes_of(a.triangles);
}

// Positions compare by bits, except that both zeros are one.
std::array<uint32_t, 3> position_key(const Vec3f& p) {
  return {std::bit_cast<uint32_t>(p.x + 0.0f), std::bit_cast<uint32_t>(p.y + 0.0f),
          std::bit_cast<uint32_t>(p.z + 0.0f)};
}

// Grouped by the lower of their points; each stands for the other. `weld` empty: points are their own.
GroupedItems<uint32_t> edges_of(const Mesh& mesh, const std::vector<int>& weld, const CancelToken& cancel) {
  const auto each_edge = [&](const auto& add) {
    for (const auto& t : mesh.triangles) {
      cancel.check();
      Corners v = t;
      if (!weld.empty())
        for (uint32_t& i : v) i = static_cast<uint32_t>(weld[i]);
      if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0]) continue;  // no area: its two long edges pair with each other
      for (size_t i = 0; i < 3; ++i) {
        const uint32_t a = v[i], b = v[(i + 1) % 3];
        add(std::min(a, b), std::max(a, b));
      }
    }
  };
  return {mesh.points.size(), each_edge, cancel};
}

// By the number of triangles at edges: odd somewhere; two everywhere; even, and more than two somewhere.
enum class Pairing { odd, pairs, even };

Pairing pairing_of(const Mesh& mesh, const std::vector<int>& weld, const CancelToken& cancel) {
  const GroupedItems<uint32_t> edges = edges_of(mesh, weld, cancel);
  bool any = false, more = false;
  for (size_t point = 0; point < edges.size(); ++point) {
    const auto ends = edges[point];
    any |= !ends.empty();
    for (size_t i = 0; i < ends.size(); i += 2) {
      if (i + 1 == ends.size() || ends[i] != ends[i + 1]) return Pairing::odd;
      more |= i > 0 && ends[i] == ends[i - 1];
    }
  }
  return !any ? Pairing::odd : more ? Pairing::even : Pairing::pairs;
}

std::shared_ptr<const ShellTopology> topology_of(const Mesh& mesh, const std::vector<int>& weld,
                                                 const CancelToken& cancel) {
  const auto first = [&](uint32_t point) { return static_cast<uint32_t>(weld[point]); };
  std::vector<WeldedCorners> corners;
  corners.reserve(mesh.triangles.size());
  for (const auto& t : mesh.triangles) corners.push_back({first(t[0]), first(t[1]), first(t[2])});
  return find_shell_topology(std::move(corners), mesh.points.size(), cancel);
}

// A sheet that was doubled encloses nothing, though its edges are paired.
bool has_closed_shell(const ShellTopology& topology) {
  for (size_t s = 0; s < topology.shells.size(); ++s)
    if (!topology.open[s] && !topology.inner[s]) return true;
  return false;
}

// Welding only adds up even numbers, so what is closed without it stays closed.
void find_closed(const Mesh* before, const CancelToken& cancel, Mesh* mesh) {
  mesh->sealed = before && before->sealed && before->triangles == mesh->triangles;
  if (!mesh->sealed) mesh->sealed = pairing_of(*mesh, {}, cancel) == Pairing::pairs;
  mesh->closed = mesh->sealed;
  if (mesh->sealed) return;
  const std::vector<int> weld = weld_by_position(mesh->points, cancel);
  const Pairing welded = pairing_of(*mesh, weld, cancel);
  mesh->closed =
      welded == Pairing::pairs || (welded == Pairing::even && has_closed_shell(*topology_of(*mesh, weld, cancel)));
}

// By tetrahedra over the centre of the bounds, so that no digits cancel. Those of doubled faces do.
bool encloses_positive_volume(const Mesh& mesh) {
  const Vec3d center(mesh.bounds.center());
  constexpr double kLeastShare = 1e-9;
  double volume = 0, all = 0;
  for (const auto& t : mesh.triangles) {
    const double one = dot(Vec3d(mesh.points[t[0]]) - center,
                           cross(Vec3d(mesh.points[t[1]]) - center, Vec3d(mesh.points[t[2]]) - center));
    volume += one, all += std::abs(one);
  }
  return volume > kLeastShare * all;
}

template <class T>
uint32_t value_index(const Primvar<T>& primvar, int vertex, uint32_t corner) {
  const size_t id = primvar.interpolation == Interpolation::face_varying ? size_t(corner) : static_cast<size_t>(vertex);
  return static_cast<uint32_t>(primvar.indices.empty() ? static_cast<int>(id) : primvar.indices[id]);
}

// The cage's own faces as triangles.
class FlatBuilder {
 public:
  explicit FlatBuilder(const Cage& cage) : cage_(cage), hole_(cage.face_vertex_counts.size(), false) {
    for (int face : cage.hole_indices) hole_[static_cast<size_t>(face)] = true;
    for (int face : cage.invisible_faces) hole_[static_cast<size_t>(face)] = true;
  }

  Mesh build() {
    mesh_.points = cage_.points;
    mesh_.normals = cage_.normals.values;
    const size_t triangles = cage_.face_vertex_indices.size() - 2 * hole_.size();
    const std::vector<CoincidentFace> coincident = find_coincident_faces(cage_);
    mesh_.triangles.reserve(triangles), face_corners_.reserve(triangles), mesh_.triangle_face.reserve(triangles);
    auto next = coincident.begin();
    size_t first = 0;
    for (size_t face = 0; face < hole_.size(); ++face) {
      const size_t count = static_cast<size_t>(cage_.face_vertex_counts[face]);
      const bool is_coincident = next != coincident.end() && next->face == face;
      if (!hole_[face]) {
        triangulate(first, count, is_coincident ? &*next : nullptr);
        add_face(face, first);
      }
      if (is_coincident) ++next;
      first += count;
    }
    pair_up(&mesh_.triangles, &face_corners_);
    if (cage_.has_smooth_normals()) mesh_.normals = smooth_normals();
    if (!cage_.normals.empty()) mesh_.normal_triangles = attribute_triangles(cage_.normals);
    mesh_.tangents = attribute(cage_.tangents);
    for (const UvPrimvar& uv : cage_.uvs) mesh_.uv_sets.push_back({attribute<Vec2f>(uv), uv.name});
    for (const NamedPrimvar& named : cage_.primvars)
      std::visit(
          [&](const auto& primvar) {
            mesh_.primvars.push_back({attribute(primvar), named.name});
          },
          named.values);
    return std::move(mesh_);
  }

  std::vector<Vec3f> smooth_normals() {
    vertex_normals_.assign(cage_.points.size(), Vec3d(0, 0, 0));
    size_t first = 0;
    // Holes shape smooth normals as they shape the limit surface.
    for (const int corners : cage_.face_vertex_counts) {
      const auto count = static_cast<size_t>(corners);
      gather(first, count);
      add_normal(first, count);
      first += count;
    }
    std::vector<Vec3f> normals;
    normals.reserve(vertex_normals_.size());
    for (const Vec3d& n : vertex_normals_) {
      const double l = length(n);
      // Zero (faces that cancel): the hit falls back to the geometric normal.
      normals.push_back(l > 0 ? Vec3f(n / l) : Vec3f(0, 0, 0));
    }
    return normals;
  }

 private:
  template <class T>
  std::vector<Corners> attribute_triangles(const Primvar<T>& primvar) const {
    std::vector<Corners> triangles(mesh_.triangles);
    for (size_t t = 0; t < triangles.size(); ++t)
      for (size_t i = 0; i < 3; ++i)
        triangles[t][i] = value_index(primvar, static_cast<int>(mesh_.triangles[t][i]), face_corners_[t][i]);
    return triangles == mesh_.triangles ? std::vector<Corners>() : triangles;
  }
  template <class T>
  MeshAttribute<T> attribute(const Primvar<T>& primvar) const {
    if (primvar.empty()) return {};
    return {primvar.values, attribute_triangles(primvar)};
  }

  void gather(size_t first, size_t count) {
    corners_.clear();
    for (size_t k = first; k < first + count; ++k)
      corners_.emplace_back(Vec3d(cage_.points[static_cast<size_t>(cage_.face_vertex_indices[k])]));
  }

  // Faces that lie on each other are cut alike: else the two diagonals of a doubled quad would enclose a body.
  void triangulate(size_t first, size_t count, const CoincidentFace* coincident) {
    local_.clear();
    gather(coincident ? coincident->first_corner : first, count);
    triangulate_polygon(corners_, &local_);
    if (!coincident) return;
    local_ = cut_alike(cage_, *coincident, first, local_);
    if (local_.empty()) triangulate(first, count, nullptr);
  }

  void add_face(size_t face, size_t first) {
    for (auto t : local_) {
      if (cage_.left_handed) std::swap(t[1], t[2]);
      Corners points{}, corners{};
      for (size_t i = 0; i < 3; ++i) {
        corners[i] = static_cast<uint32_t>(first + static_cast<size_t>(t[i]));
        points[i] = static_cast<uint32_t>(cage_.face_vertex_indices[corners[i]]);
      }
      mesh_.triangles.push_back(points);
      face_corners_.push_back(corners);
      mesh_.triangle_face.push_back(static_cast<int32_t>(face));
      if (!cage_.face_material.empty()) mesh_.triangle_material.push_back(cage_.face_material[face]);
    }
  }

  // In double, so that the sum does not depend on how far from the origin the mesh lies.
  void add_normal(size_t first, size_t count) {
    const Vec3d n = polygon_normal(corners_) * (cage_.left_handed ? -1.0 : 1.0);
    for (size_t k = first; k < first + count; ++k)
      vertex_normals_[static_cast<size_t>(cage_.face_vertex_indices[k])] += n;
  }

  const Cage& cage_;
  std::vector<bool> hole_;
  std::vector<Vec3d> corners_, vertex_normals_;
  std::vector<std::array<int, 3>> local_;
  std::vector<Corners> face_corners_;  // of each triangle
  Mesh mesh_;
};

int checked_level(const Cage& cage, const RefinementOptions& options, const DiagnosticSink& sink) {
  if (cage.scheme == SubdivisionScheme::none) return 0;
  const int level = std::clamp(options.level, 0, kMaxSubdivisionLevel);
  if (level != options.level)
    report(sink, Severity::warning, "mesh.subdivision.level", options.where,
           "subdivision level " + std::to_string(options.level) + " is outside 0 to " +
               std::to_string(kMaxSubdivisionLevel) + "; using " + std::to_string(level));
  return level;
}

}  // namespace

template <class T>
static const T* find_named(const std::vector<T>& all, const UvSetName& name) {
  const auto found = std::find_if(all.begin(), all.end(), [&](const T& one) { return one.name == name; });
  return found == all.end() ? nullptr : &*found;
}
const UvSet* Mesh::uv_set(const UvSetName& name) const {
  return find_named(uv_sets, name);
}
const NamedAttribute* Mesh::primvar(const UvSetName& name) const {
  return find_named(primvars, name);
}

std::array<Vec3f, 3> Mesh::posed_corners(uint32_t triangle, float time) const {
  const Corners& c = triangles[triangle];
  return {point_at(c[0], time), point_at(c[1], time), point_at(c[2], time)};
}

size_t Mesh::memory_bytes() const {
  size_t bytes = bytes_of(points) + bytes_of(triangles) + bytes_of(normals) + bytes_of(normal_triangles) +
                 bytes_of(tangents) + bytes_of(triangle_face) + bytes_of(triangle_material);
  for (const UvSet& set : uv_sets) bytes += bytes_of<Vec2f>(set);
  for (const NamedAttribute& named : primvars)
    bytes += std::visit([](const auto& attribute) { return bytes_of(attribute); }, named.values);
  for (const MeshPose& pose : later_poses) bytes += bytes_of(pose.points) + bytes_of(pose.normals);
  return bytes;
}

// By sorting: no choice of points makes it slow, as one does where they are hashed.
std::vector<int> weld_by_position(const std::vector<Vec3f>& points, const CancelToken& cancel) {
  std::vector<std::array<uint32_t, 4>> keys(points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    const auto key = position_key(points[i]);
    keys[i] = {key[0], key[1], key[2], static_cast<uint32_t>(i)};
  }
  tbb::parallel_sort(keys.begin(), keys.end(), CancellableLess{cancel});
  std::vector<int> first(points.size());
  for (size_t i = 0, run = 0; i < keys.size(); ++i) {
    cancel.check();
    if (!std::equal(keys[i].begin(), keys[i].begin() + 3, keys[run].begin())) run = i;
    first[keys[i][3]] = static_cast<int>(keys[run][3]);
  }
  return first;
}

namespace {

/// The faces at an edge. Triangles that lie on each other count once.
struct EdgeFaces {
  Vec3f from, to;               // the edge's ends
  size_t count = 0, along = 0;  // along: that run from one end to the other
};

/// Calls visit(EdgeFaces) for each edge after welding. Walls within a body do not count.
template <class Visit>
void for_each_edge(const Mesh& mesh, const Visit& visit) {
  const auto topology = topology_of(mesh, weld_by_position(mesh.points, {}), {});
  using Kind = ShellTopology::Kind;
  struct Face {
    uint32_t other;  // point
    bool along, is_doubled;
    bool operator<(const Face& f) const { return other < f.other; }
  };
  const auto each = [&](const auto& add) {
    for (size_t t = 0; t < topology->corners.size(); ++t) {
      const Kind kind = topology->kind[t];
      if (kind == Kind::kCopy || kind == Kind::kDegenerate || topology->inner[topology->shell[t]]) continue;
      for (size_t i = 0; i < 3; ++i) {
        const uint32_t a = topology->corners[t][i], b = topology->corners[t][(i + 1) % 3];
        add(std::min(a, b), Face{std::max(a, b), a < b, kind == Kind::kBackToBack});
      }
    }
  };
  const GroupedItems<Face> faces(mesh.points.size(), each, {});
  for (uint32_t point = 0; point < faces.size(); ++point)
    for_each_run(
        faces[point], [](const Face& a, const Face& b) { return a.other == b.other; },
        [&](std::span<const Face> edge) {
          EdgeFaces all{mesh.points[point], mesh.points[edge[0].other]};
          size_t doubled = 0;
          for (const Face& face : edge) {
            doubled += face.is_doubled;
            all.count += !face.is_doubled;
            all.along += face.along && !face.is_doubled;
          }
          all.count += doubled / 2;
          if (doubled > 0) all.along = all.count / 2;  // they wind either way
          visit(all);
        });
}

void add_edge(const EdgeFaces& edge, OpenEdges::Kind* kind) {
  if (kind->count++ == 0) kind->first = {edge.from, edge.to};
}

}  // namespace

OpenEdges find_open_edges(const Mesh& mesh) {
  OpenEdges found;
  for_each_edge(mesh, [&](const EdgeFaces& edge) {
    if (edge.count % 2 == 1) add_edge(edge, edge.count == 1 ? &found.of_one : &found.of_more);
  });
  return found;
}

OpenEdges::Kind find_reversed_edges(const Mesh& mesh) {
  OpenEdges::Kind found;
  for_each_edge(mesh, [&](const EdgeFaces& edge) {
    if (edge.count % 2 == 0 && 2 * edge.along != edge.count) add_edge(edge, &found);
  });
  return found;
}

static void mend_vectors(const Cage& cage, const RefinementOptions& options, const DiagnosticSink& sink, Mesh* mesh) {
  const auto warn = [&](const char* code, const MendedVectors& mended, const std::string& text) {
    if (mended.count > 0)
      report(sink, Severity::warning, code, options.where,
             std::to_string(mended.count) + " " + text + " (first: face " + std::to_string(mended.element) + ")");
  };
  if (!cage.normals.empty())
    warn("mesh.normals.unusable", mend_normals(mesh),
         "normals are zero or not finite, and are replaced by those of the faces around");
  const MendedVectors tangents = find_unusable_tangents(*mesh);
  constexpr double kTangentBytes = 276;  // of a triangle, while they are computed
  if (tangents.count > 0) {
    const auto triangles = static_cast<double>(mesh->triangles.size());
    hold_build(options, triangles, static_cast<double>(mesh->memory_bytes()) + kTangentBytes * triangles);
  }
  mend_tangents(mesh, tangents.count);
  warn("mesh.tangents.unusable", tangents,
       "tangents of corners are zero, not finite, without sign or along the normal, and are computed from the texture "
       "coordinates; without these the mesh has no tangents");
}

Mesh build_mesh(const Cage& cage, const RefinementOptions& options, const DiagnosticSink& sink) {
  RefinementOptions fitting = options;
  fitting.level = checked_level(cage, options, sink);
  if (!options.segments || fitting.level == 0)
    hold_build(options, static_cast<double>(count_triangles(cage, fitting.level)),
               static_cast<double>(estimate_mesh_bytes(cage, fitting.level)));
  std::optional<Mesh> refined;
  if (fitting.level > 0) refined = tessellate_limit_surface(cage, fitting, sink);
  Mesh mesh = refined ? std::move(*refined) : FlatBuilder(cage).build();
  if (!refined) mend_vectors(cage, options, sink, &mesh);
  options.cancel.check();
  if (options.displace) options.displace(&mesh);
  for (const auto& t : mesh.triangles)
    for (uint32_t i : t) mesh.bounds.extend(mesh.points[i]);
  find_closed(options.before, options.cancel, &mesh);
  mesh.outward = mesh.closed && encloses_positive_volume(mesh);
  hold_mesh(options, static_cast<double>(mesh.triangles.size()), static_cast<double>(mesh.memory_bytes()));
  return mesh;
}

// options.memory holds what it takes beside a copy of the cage.
MeshPose pose_mesh(const Cage& cage, const RefinementOptions& options, MeshPose posed) {
  Cage moved = cage;
  moved.points = posed.points;
  if (options.displace) {
    moved.normals.values = posed.normals;
    Mesh displaced = build_mesh(moved, options, {});
    return {std::move(displaced.points), std::move(displaced.normals)};
  }
  RefinementOptions fitting = options;
  fitting.level = checked_level(cage, options, {});
  hold_mesh(options, static_cast<double>(count_triangles(cage, fitting.level)),
            static_cast<double>(estimate_mesh_bytes(cage, fitting.level)));
  if (fitting.level > 0) {
    moved.uvs.clear();
    moved.primvars.clear();
    if (auto refined = tessellate_limit_surface(moved, fitting, {}))
      return {std::move(refined->points), std::move(refined->normals)};
  }
  if (cage.has_smooth_normals()) posed.normals = FlatBuilder(moved).smooth_normals();
  if (cage.normals.empty() || are_usable(posed.normals)) return posed;
  Mesh mesh = FlatBuilder(moved).build();
  mesh.normals = std::move(posed.normals);
  mend_normals(&mesh);
  posed.normals = std::move(mesh.normals);
  return posed;
}

}  // namespace alabaster
