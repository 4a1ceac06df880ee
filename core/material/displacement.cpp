#include "core/material/displacement.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <map>
#include <tuple>

#include "core/geometry/tangents.h"

namespace alabaster {
namespace {

// Corners are numbered 3 * triangle + corner.
class Displacer {
 public:
  Displacer(const Displacements& displacements, Mesh* mesh, const CancelToken& cancel)
      : cancel_(cancel), displacements_(displacements), mesh_(*mesh), first_(weld_by_position(mesh->points, cancel)) {
    gather_corners();
    compute_tangent_frames();
  }

  /// Returns how many points had to keep their place.
  size_t run() {
    angles_ = corner_angles();
    std::vector<Vec3f> moved = mesh_.points;
    std::vector<uint8_t> kept(mesh_.points.size(), 0);
    for_each_place([&](size_t place) {
      const Vec3f p(Vec3d(mesh_.points[place]) + displacement_at(place));
      kept[place] = !is_finite(p) || max_abs_component(p) >= kTraceLimit;
      if (!kept[place]) moved[place] = p;
    });
    leaders_ = corners_by_normal();
    for (size_t i = 0; i < moved.size(); ++i) mesh_.points[i] = moved[at(first_[i])];
    if (!mesh_.normals.empty()) recompute_normals();
    mesh_.tangents = {};
    size_t number = 0;
    for (const uint8_t k : kept) number += k;
    return number;
  }

 private:
  static size_t at(int i) { return static_cast<size_t>(i); }

  // The corners at each place, in ascending order: sums do not depend on threads.
  void gather_corners() {
    starts_.assign(mesh_.points.size() + 1, 0);
    for (const Corners& t : mesh_.triangles)
      for (const uint32_t p : t) ++starts_[at(first_[p]) + 1];
    for (size_t i = 1; i < starts_.size(); ++i) starts_[i] += starts_[i - 1];
    corners_.resize(3 * mesh_.triangles.size());
    std::vector<uint32_t> next(starts_.begin(), starts_.end() - 1);
    for (uint32_t c = 0; c < corners_.size(); ++c) corners_[next[at(first_[mesh_.triangles[c / 3][c % 3]])]++] = c;
  }
  std::span<const uint32_t> corners_at(size_t place) const {
    return {corners_.data() + starts_[place], corners_.data() + starts_[place + 1]};
  }

  // Places are the first points of those that share a position.
  template <class F>
  void for_each_place(const F& work) const {
    tbb::parallel_for(tbb::blocked_range<size_t>(0, first_.size(), 256), [&](const tbb::blocked_range<size_t>& range) {
      cancel_.check();
      for (size_t i = range.begin(); i < range.end(); ++i)
        if (at(first_[i]) == i && starts_[i] < starts_[i + 1]) work(i);
    });
  }

  // On the surface as it is before it moves: the limit surface, if the mesh is refined.
  void compute_tangent_frames() {
    for (const auto& d : displacements_)
      if (d && d->space == DisplacementSpace::tangent && !tangents_.contains(d->texture.primvar.text())) {
        const UvSet* const uvs = mesh_.uv_set(d->texture.primvar);
        if (!mesh_.tangents.empty())
          tangents_[d->texture.primvar.text()] = mesh_.tangents;
        else if (uvs)
          tangents_[d->texture.primvar.text()] = compute_tangents(mesh_, *uvs);
      }
  }

  Vec3d point(uint32_t corner) const { return Vec3d(mesh_.points[mesh_.triangles[corner / 3][corner % 3]]); }
  Vec3d facet(uint32_t triangle) const {
    const Vec3d p = point(3 * triangle);
    return cross(point(3 * triangle + 1) - p, point(3 * triangle + 2) - p);
  }

  std::vector<double> corner_angles() const {
    std::vector<double> angles(corners_.size());
    tbb::parallel_for(size_t(0), mesh_.triangles.size(), [&](size_t t) {
      for (uint32_t i = 0; i < 3; ++i) {
        const auto first = static_cast<uint32_t>(3 * t);
        const Vec3d p = point(first + i), a = point(first + (i + 1) % 3) - p, b = point(first + (i + 2) % 3) - p;
        angles[3 * t + i] = std::atan2(length(cross(a, b)), dot(a, b));
      }
    });
    return angles;
  }

  static Vec3d unit_or_zero(const Vec3d& v) {
    const double l = length(v);
    return l > 0 ? v / l : Vec3d(0, 0, 0);
  }

  uint32_t normal_index(uint32_t corner) const {
    return (mesh_.normal_triangles.empty() ? mesh_.triangles : mesh_.normal_triangles)[corner / 3][corner % 3];
  }
  // The shading normal, or the triangle's where there is none.
  Vec3d normal(uint32_t corner) const {
    const Vec3d n = mesh_.normals.empty() ? Vec3d(0, 0, 0) : Vec3d(mesh_.normals[normal_index(corner)]);
    return unit_or_zero(dot(n, n) > 0 ? n : facet(corner / 3));
  }

  const Displacement* displacement_of(uint32_t corner) const {
    const auto& slots = mesh_.triangle_material;
    const size_t slot = slots.empty() ? 0 : at(slots[corner / 3]);
    const auto& d = displacements_[slot < displacements_.size() ? slot : 0];
    return d ? &*d : nullptr;
  }

  // The value at a corner: a height in x, or a vector in object space.
  Vec3d value_at(const Displacement& d, uint32_t corner) const {
    TriangleHit hit;
    hit.triangle = corner / 3;
    hit.u = corner % 3 == 1, hit.v = corner % 3 == 2;
    const Vec2f uv = mesh_.uv_sets.empty() ? Vec2f(0, 0) : interpolated<Vec2f>(mesh_.uv_sets.front(), mesh_, hit);
    const HitPrimvars primvars(mesh_, hit, uv);
    const auto scaled = [&](float value) { return (double(value) - double(d.midlevel)) * double(d.scale); };
    if (d.channel == Channel::a) return {scaled(d.texture.alpha(primvars)), 0, 0};
    const Rgb value = d.texture.color(primvars);
    if (d.space == DisplacementSpace::normal) return {scaled(value[component_of(d.channel)]), 0, 0};
    const Vec3d v(scaled(value.r), scaled(value.g), scaled(value.b));
    return d.space == DisplacementSpace::object ? v : from_tangent_space(d, corner, hit, v);
  }

  Vec3d from_tangent_space(const Displacement& d, uint32_t corner, const TriangleHit& hit, const Vec3d& v) const {
    const Vec3d n = normal(corner);
    const auto tangents = tangents_.find(d.texture.primvar.text());
    if (tangents == tangents_.end()) return n * v.z;
    const Vec4f tangent = interpolated(tangents->second, mesh_, hit);
    const Vec3d along(tangent.x, tangent.y, tangent.z);
    const Vec3d t = unit_or_zero(along - n * dot(along, n));
    return t * v.x + cross(n, t) * (tangent.w < 0 ? -v.y : v.y) + n * v.z;
  }

  // Heights move a place along one direction, however its corners' normals differ.
  Vec3d displacement_at(size_t place) const {
    double weights = 0, heights = 0;
    Vec3d vectors(0, 0, 0), normals(0, 0, 0);
    for (const uint32_t corner : corners_at(place)) {
      const double weight = angles_[corner];
      weights += weight;
      normals += normal(corner) * weight;
      const Displacement* const d = displacement_of(corner);
      if (!d) continue;
      const Vec3d value = value_at(*d, corner) * weight;
      if (d->space == DisplacementSpace::normal)
        heights += value.x;
      else
        vectors += value;
    }
    return weights > 0 ? (unit_or_zero(normals) * heights + vectors) / weights : Vec3d(0, 0, 0);
  }

  // For each corner the first one at its place that has the same normal.
  std::vector<uint32_t> corners_by_normal() const {
    std::vector<uint32_t> leaders(mesh_.normals.empty() ? 0 : corners_.size());
    if (leaders.empty()) return leaders;
    for_each_place([&](size_t place) {
      const auto corners = corners_at(place);
      const auto before = [&](uint32_t a, uint32_t b) {
        const auto key = [&](uint32_t c) {
          const Vec3f& n = mesh_.normals[normal_index(c)];
          return std::tuple(n.x, n.y, n.z, c);
        };
        return key(a) < key(b);
      };
      std::vector<uint32_t> sorted(corners.begin(), corners.end());
      std::sort(sorted.begin(), sorted.end(), before);
      for (size_t i = 0; i < sorted.size(); ++i)
        leaders[sorted[i]] = i && same_normal(sorted[i - 1], sorted[i]) ? leaders[sorted[i - 1]] : sorted[i];
    });
    return leaders;
  }
  bool same_normal(uint32_t a, uint32_t b) const {
    return mesh_.normals[normal_index(a)] == mesh_.normals[normal_index(b)];
  }

  // Sums of these are exact on spheres, whatever diagonals quads were cut along.
  Vec3d normal_of_corner(uint32_t corner) const {
    const uint32_t t = corner / 3 * 3;
    const Vec3d p = point(corner), a = point(t + (corner + 1) % 3) - p, b = point(t + (corner + 2) % 3) - p;
    const double l2 = dot(a, a) * dot(b, b);
    return l2 > 0 ? cross(a, b) / l2 : Vec3d(0, 0, 0);
  }

  void recompute_normals() {
    std::vector<Vec3d> sums(corners_.size(), Vec3d(0, 0, 0));
    for_each_place([&](size_t place) {
      for (const uint32_t c : corners_at(place)) sums[leaders_[c]] += normal_of_corner(c);
    });
    const auto new_normal = [&](uint32_t corner) { return Vec3f(unit_or_zero(sums[leaders_[corner]])); };
    if (mesh_.normal_triangles.empty()) {
      for (uint32_t c = 0; c < corners_.size(); ++c) mesh_.normals[normal_index(c)] = new_normal(c);
      return;
    }
    // Corners at different places may have shared a normal.
    std::vector<uint32_t> index(corners_.size());
    mesh_.normals.clear();
    for (uint32_t c = 0; c < corners_.size(); ++c)
      if (leaders_[c] == c) {
        index[c] = static_cast<uint32_t>(mesh_.normals.size());
        mesh_.normals.push_back(new_normal(c));
      }
    for (uint32_t c = 0; c < corners_.size(); ++c) mesh_.normal_triangles[c / 3][c % 3] = index[leaders_[c]];
  }

  const CancelToken cancel_;
  const Displacements& displacements_;
  Mesh& mesh_;
  std::vector<int> first_;  // the place of each point
  std::vector<uint32_t> starts_, corners_;
  std::vector<double> angles_;                            // of each corner, before it moves
  std::vector<uint32_t> leaders_;                         // of corners that share a normal
  std::map<std::string, MeshAttribute<Vec4f>> tangents_;  // by uv set
};

void report_missing_uvs(const Displacements& displacements, const Mesh& mesh, const std::string& where,
                        const DiagnosticSink& sink) {
  for (const auto& d : displacements)
    if (d && d->texture.image && !mesh.uv_set(d->texture.primvar))
      return report(sink, Severity::warning, "mesh.displacement.uvs", where,
                    "the mesh has no texture coordinates '" + d->texture.primvar.text() +
                        "', which its displacement asks for; the texture is read at (0, 0)");
}

}  // namespace

void displace(const Displacements& displacements, const std::string& where, const DiagnosticSink& sink, Mesh* mesh,
              const CancelToken& cancel) {
  report_missing_uvs(displacements, *mesh, where, sink);
  if (const size_t kept = Displacer(displacements, mesh, cancel).run())
    report(sink, Severity::error, "mesh.displacement.nonfinite", where,
           std::to_string(kept) + " displaced points are not finite or beyond 1e17; they are not displaced");
}

}  // namespace alabaster
