#include "delegate/gltf/gltf_surfaces.h"

#include <algorithm>
#include <array>
#include <bit>
#include <numeric>
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

std::vector<Edge> open_edges(const SurfacePiece& piece) {
  const std::vector<uint32_t>& corners = *piece.triangles;
  std::vector<Edge> edges;
  edges.reserve(corners.size());
  for (size_t i = 0; i < corners.size(); ++i) {
    const size_t next = i % 3 == 2 ? i - 2 : i + 1;
    Position a = position_of((*piece.points)[corners[i]]), b = position_of((*piece.points)[corners[next]]);
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

}  // namespace

std::vector<size_t> surfaces_of(const std::vector<SurfacePiece>& pieces) {
  std::vector<size_t> first(pieces.size());
  std::iota(first.begin(), first.end(), size_t(0));
  const auto find = [&](size_t i) {
    while (first[i] != i) i = first[i] = first[first[i]];
    return i;
  };
  std::vector<std::pair<Edge, size_t>> all;
  for (size_t i = 0; i < pieces.size(); ++i) {
    const auto has_key = [&](const SurfacePiece& piece) { return piece.key == pieces[i].key; };
    if (std::count_if(pieces.begin(), pieces.end(), has_key) < 2) continue;
    for (const Edge& edge : open_edges(pieces[i])) all.emplace_back(edge, i);
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

}  // namespace alabaster::hd::gltf
