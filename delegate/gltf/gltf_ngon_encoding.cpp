#include "delegate/gltf/gltf_ngon_encoding.h"

#include <algorithm>
#include <array>
#include <bit>
#include <map>
#include <span>

namespace alabaster::hd::gltf {
namespace {

Imath::V3d newell_normal(const std::vector<Imath::V3d>& polygon) {
  Imath::V3d normal(0);
  for (size_t i = 1; i + 1 < polygon.size(); ++i)
    normal += (polygon[i] - polygon[0]).cross(polygon[i + 1] - polygon[0]);
  return normal;
}

// The shortest run of triangles that two consecutive quads could have made.
constexpr size_t kSuspectRun = 4;

// True if every corner turns the same way around the polygon's mean normal. Nearly straight corners fail: two quads
// joined along an edge have them at the ends of the edge, but polygons of a modeller seldom do.
bool is_convex(const std::vector<Imath::V3d>& polygon) {
  constexpr double kSmallestTurn = 0.1;  // sine
  const Imath::V3d normal = newell_normal(polygon).normalized();
  const size_t n = polygon.size();
  for (size_t i = 0; i < n; ++i) {
    const Imath::V3d in = (polygon[i] - polygon[(i + n - 1) % n]).normalized();
    const Imath::V3d out = (polygon[(i + 1) % n] - polygon[i]).normalized();
    if (in.cross(out).dot(normal) < kSmallestTurn) return false;
  }
  return true;
}

// Ordered, not hashed: no choice of points makes finding one of them slow.
using FloatKey = std::array<uint32_t, 5>;
uint32_t float_bits(float value) {
  return std::bit_cast<uint32_t>(value + 0.0f);  // -0 and 0 are the same place
}

class CageBuilder {
 public:
  explicit CageBuilder(const std::vector<Vec3f>& points) {
    std::map<FloatKey, int32_t> places;
    cage_.vertex_points.reserve(points.size());
    for (size_t vertex = 0; vertex < points.size(); ++vertex) {
      const Vec3f& p = points[vertex];
      const FloatKey key{{float_bits(p.x), float_bits(p.y), float_bits(p.z)}};
      const auto [found, is_new] = places.try_emplace(key, int32_t(cage_.point_vertices.size()));
      if (is_new) cage_.point_vertices.push_back(uint32_t(vertex));
      cage_.vertex_points.push_back(found->second);
    }
  }

  // Adds a polygon, given by the original vertices of its corners.
  void add(std::vector<uint32_t> corners) {
    const auto same_place = [&](uint32_t a, uint32_t b) { return cage_.vertex_points[a] == cage_.vertex_points[b]; };
    corners.erase(std::unique(corners.begin(), corners.end(), same_place), corners.end());
    while (corners.size() > 1 && same_place(corners.front(), corners.back())) corners.pop_back();
    if (corners.size() < 3) {
      ++cage_.dropped_faces;
      return;
    }
    if (corners.size() > 3 && has_repeated_point(corners)) {
      for (size_t i = 1; i + 1 < corners.size(); ++i) add({corners[0], corners[i], corners[i + 1]});
      return;
    }
    cage_.face_vertex_counts.push_back(int32_t(corners.size()));
    for (const uint32_t corner : corners) {
      cage_.face_vertex_indices.push_back(cage_.vertex_points[corner]);
      cage_.corner_vertices.push_back(corner);
    }
  }

  void end_part() { cage_.part_ends.push_back(cage_.face_vertex_counts.size()); }
  Cage take() { return std::move(cage_); }

 private:
  bool has_repeated_point(const std::vector<uint32_t>& corners) const {
    std::vector<int32_t> places;
    for (const uint32_t corner : corners) places.push_back(cage_.vertex_points[corner]);
    std::sort(places.begin(), places.end());
    return std::adjacent_find(places.begin(), places.end()) != places.end();
  }

  Cage cage_;
};

// The number of triangles of each polygon in a triangle list, in order. Exporters promise that consecutive polygons do
// not share their first index, but some break the promise. Most such polygons are not chained, which separates them.
// Two quads that are chained look like a hexagon, so a run of four or more triangles counts as one polygon only if it
// is convex, and is cut into quads otherwise. (Runs of three are never cut: pentagons of real cages are often neither
// flat nor convex.)
std::vector<uint32_t> find_polygons(std::span<const uint32_t> triangles, const std::vector<Vec3f>& points) {
  std::vector<uint32_t> polygons;
  const size_t count = triangles.size() / 3;
  std::vector<Imath::V3d> corners;
  for (size_t first = 0; first < count;) {
    size_t end = first + 1;
    const uint32_t* t = &triangles[first * 3];
    corners = {Imath::V3d(points[t[0]]), Imath::V3d(points[t[1]]), Imath::V3d(points[t[2]])};
    const auto chains = [&] {
      const uint32_t* next = &triangles[end * 3];
      if (next[0] != t[0] || next[1] != triangles[end * 3 - 1]) return false;
      for (size_t k = first; k < end; ++k)  // a fan that returns to an earlier corner is closed
        if (next[2] == triangles[k * 3 + 1]) return false;
      return true;
    };
    while (end < count && chains()) {
      corners.push_back(Imath::V3d(points[triangles[end * 3 + 2]]));
      ++end;
    }
    const size_t run = end - first;
    if (run < kSuspectRun || is_convex(corners)) {
      polygons.push_back(uint32_t(run));
    } else {
      for (size_t left = run; left > 0; left -= std::min<size_t>(left, 2))
        polygons.push_back(uint32_t(std::min<size_t>(left, 2)));
    }
    first = end;
  }
  return polygons;
}

}  // namespace

Cage build_cage(const std::vector<uint32_t>& triangles, const std::vector<Vec3f>& points,
                const std::vector<size_t>& ends) {
  CageBuilder builder(points);
  size_t triangle = 0;
  for (const size_t end : ends) {
    const std::span<const uint32_t> part(&triangles[triangle * 3], &triangles[0] + end);
    for (const uint32_t count : find_polygons(part, points)) {
      std::vector<uint32_t> corners = {triangles[triangle * 3], triangles[triangle * 3 + 1]};
      for (size_t k = 0; k < count; ++k) corners.push_back(triangles[(triangle + k) * 3 + 2]);
      builder.add(std::move(corners));
      triangle += count;
    }
    builder.end_part();
  }
  return builder.take();
}

CornerValues weld_corners(const Cage& cage, const std::vector<float>& values, size_t components) {
  CornerValues welded;
  std::map<FloatKey, int32_t> known;
  for (size_t corner = 0; corner < cage.corner_vertices.size(); ++corner) {
    const uint32_t vertex = cage.corner_vertices[corner];
    FloatKey key{{uint32_t(cage.face_vertex_indices[corner])}};
    for (size_t c = 0; c < components; ++c) key[c + 1] = float_bits(values[vertex * components + c]);
    const auto [found, is_new] = known.try_emplace(key, int32_t(welded.vertices.size()));
    if (is_new) welded.vertices.push_back(vertex);
    welded.indices.push_back(found->second);
  }
  return welded;
}

}  // namespace alabaster::hd::gltf
