#include "core/geometry/coincident_faces.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <span>
#include <tuple>
#include <utility>

#include "core/digest/digest.h"

namespace alabaster {
namespace {

const Vec3f& corner_point(const Cage& cage, size_t corner) {
  return cage.points[static_cast<size_t>(cage.face_vertex_indices[corner])];
}

struct HashedFace {
  uint64_t hash;  // of the positions of its corners, in any order
  uint32_t face;
  size_t first_corner;
  bool operator<(const HashedFace& other) const { return std::tie(hash, face) < std::tie(other.hash, other.face); }
};

std::vector<HashedFace> hash_faces(const Cage& cage) {
  std::vector<HashedFace> faces;
  const auto& counts = cage.face_vertex_counts;
  faces.reserve(static_cast<size_t>(std::count_if(counts.begin(), counts.end(), [](int n) { return n > 3; })));
  size_t first = 0;
  for (size_t face = 0; face < cage.face_vertex_counts.size(); ++face) {
    const auto count = static_cast<size_t>(cage.face_vertex_counts[face]);
    uint64_t hash = count;
    for (size_t k = first; k < first + count && count > 3; ++k) {
      const Vec3f& p = corner_point(cage, k);
      const std::array<float, 3> position{p.x + 0.0f, p.y + 0.0f, p.z + 0.0f};  // -0 is 0
      hash += checksum(std::as_bytes(std::span(position)), 0);
    }
    if (count > 3) faces.push_back({hash, static_cast<uint32_t>(face), first});
    first += count;
  }
  return faces;
}

}  // namespace

std::vector<CoincidentFace> find_coincident_faces(const Cage& cage) {
  std::vector<HashedFace> faces = hash_faces(cage);
  tbb::parallel_sort(faces.begin(), faces.end());
  std::vector<CoincidentFace> found;
  for (size_t i = 1, run = 0; i < faces.size(); ++i) {
    if (faces[i].hash != faces[run].hash) run = i;
    if (i == run || cage.face_vertex_counts[faces[i].face] != cage.face_vertex_counts[faces[run].face]) continue;
    found.push_back({faces[i].face, faces[run].first_corner});
  }
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.face < b.face; });
  return found;
}

std::vector<std::array<int, 3>> cut_alike(const Cage& cage, const CoincidentFace& coincident, size_t first,
                                          const std::vector<std::array<int, 3>>& earlier) {
  const auto count = static_cast<size_t>(cage.face_vertex_counts[coincident.face]);
  const auto point = [&](size_t i) { return corner_point(cage, first + i % count); };
  const auto earlier_point = [&](size_t i) { return corner_point(cage, coincident.first_corner + i); };
  size_t begin = 0;
  while (begin < count && point(begin) != earlier_point(0)) ++begin;
  for (const size_t step : {size_t(1), count - 1}) {  // forwards, backwards
    const auto corner = [&](size_t i) { return (begin + i * step) % count; };
    bool alike = begin < count;
    for (size_t i = 0; i < count && alike; ++i) alike = point(corner(i)) == earlier_point(i);
    if (!alike) continue;
    std::vector<std::array<int, 3>> triangles(earlier);
    for (auto& triangle : triangles) {
      for (int& i : triangle) i = static_cast<int>(corner(static_cast<size_t>(i)));
      if (step != 1) std::swap(triangle[1], triangle[2]);
    }
    return triangles;
  }
  return {};
}

}  // namespace alabaster
