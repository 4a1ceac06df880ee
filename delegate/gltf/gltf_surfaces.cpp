#include "delegate/gltf/gltf_surfaces.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <tuple>
#include <utility>

namespace alabaster::hd::gltf {
namespace {

using Position = std::array<uint32_t, 3>;  // its bits
using Edge = std::array<Position, 2>;      // the lesser end first

Position position_of(const Vec3f& p) {  // -0 is 0
  return {std::bit_cast<uint32_t>(p.x + 0.0f), std::bit_cast<uint32_t>(p.y + 0.0f),
          std::bit_cast<uint32_t>(p.z + 0.0f)};
}

std::vector<Edge> open_edges(const std::vector<Vec3f>& points, const std::vector<uint32_t>& corners) {
  std::vector<Edge> edges;
  edges.reserve(corners.size());
  for (size_t i = 0; i < corners.size(); ++i) {
    const size_t next = i % 3 == 2 ? i - 2 : i + 1;
    Position a = position_of(points[corners[i]]), b = position_of(points[corners[next]]);
    if (b < a) std::swap(a, b);
    if (a != b) edges.push_back({a, b});
  }
  std::sort(edges.begin(), edges.end());
  size_t open = 0;
  for (size_t i = 0, end = 0; i < edges.size(); i = end) {
    for (end = i + 1; end < edges.size() && edges[end] == edges[i];) ++end;
    if (end == i + 1) edges[open++] = edges[i];
  }
  edges.resize(open);
  return edges;
}

/// Positions of pieces by the cells of a grid. A cell keeps few, so that no choice of points makes a search slow.
class Places {
 public:
  explicit Places(float cell) : cell_(double(cell)) {}

  void add(const Vec3f& point, float step) {
    constexpr size_t kMostInCell = 16;
    std::vector<Place>& places = cells_[cell_of(point, {})];
    if (places.size() < kMostInCell) places.push_back({point, step});
  }

  /// The nearest one that rounding to both grids can have parted from `point`; null if there is none.
  const Vec3f* find(const Vec3f& point, float step) const {
    const Vec3f* best = nullptr;
    float least = std::numeric_limits<float>::max();
    for (int i = 0; i < 27; ++i) {
      const auto found = cells_.find(cell_of(point, {i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1}));
      if (found == cells_.end()) continue;
      for (const Place& place : found->second) {
        constexpr float kRounding = 1.01f;  // of the floats
        const Vec3f apart = place.point - point;
        const float most = kRounding * (place.step + step) / 2;
        if (std::max({std::abs(apart.x), std::abs(apart.y), std::abs(apart.z)}) > most) continue;
        if (!(apart.length2() < least)) continue;
        least = apart.length2();
        best = &place.point;
      }
    }
    return best;
  }

 private:
  struct Place {
    Vec3f point;
    float step;
  };
  using Cell = std::array<double, 3>;

  Cell cell_of(const Vec3f& p, const std::array<int, 3>& neighbour) const {
    return {std::floor(double(p.x) / cell_) + neighbour[0], std::floor(double(p.y) / cell_) + neighbour[1],
            std::floor(double(p.z) / cell_) + neighbour[2]};
  }

  const double cell_;
  std::map<Cell, std::vector<Place>> cells_;
};

}  // namespace

std::vector<size_t> surfaces_of(const std::vector<SurfacePiece>& pieces) {
  std::vector<size_t> first(pieces.size());
  std::iota(first.begin(), first.end(), size_t(0));
  const auto find = [&](size_t i) {
    while (first[i] != i) i = first[i] = first[first[i]];
    return i;
  };
  std::vector<std::pair<Edge, size_t>> all;
  std::map<std::string_view, int> with_key;
  for (const SurfacePiece& piece : pieces) ++with_key[piece.key];
  for (size_t i = 0; i < pieces.size(); ++i) {
    if (with_key[pieces[i].key] < 2) continue;
    for (const Edge& edge : open_edges(*pieces[i].points, *pieces[i].triangles)) all.emplace_back(edge, i);
  }
  std::sort(all.begin(), all.end(), [&](const auto& a, const auto& b) {
    return std::tie(a.first, pieces[a.second].key, a.second) < std::tie(b.first, pieces[b.second].key, b.second);
  });
  for (size_t i = 1; i < all.size(); ++i) {
    if (all[i].first != all[i - 1].first || pieces[all[i].second].key != pieces[all[i - 1].second].key) continue;
    const auto [low, high] = std::minmax({find(all[i].second), find(all[i - 1].second)});
    first[high] = low;
  }
  for (size_t i = 0; i < pieces.size(); ++i) first[i] = find(i);
  return first;
}

void join_seams(const std::vector<RoundedPiece>& pieces) {
  float cell = 0;
  for (const RoundedPiece& piece : pieces) cell = std::max(cell, piece.step);
  if (!(cell > 0) || !std::isfinite(cell) || pieces.size() < 2) return;
  Places places(1.01f * cell);
  for (const RoundedPiece& piece : pieces) {
    std::set<Position> ends;
    for (const Edge& edge : open_edges(*piece.points, *piece.triangles)) ends.insert(edge.begin(), edge.end());
    std::map<Position, Vec3f> moved;
    for (const Vec3f& point : *piece.points)
      if (const Position at = position_of(point);
          std::isfinite(point.length2()) && ends.contains(at) && !moved.contains(at)) {
        const Vec3f* const known = places.find(point, piece.step);
        moved[at] = known ? *known : point;
      }
    for (Vec3f& point : *piece.points)
      if (const auto found = moved.find(position_of(point)); found != moved.end()) point = found->second;
    for (const auto& [from, to] : moved) places.add(to, piece.step);
  }
}

}  // namespace alabaster::hd::gltf
