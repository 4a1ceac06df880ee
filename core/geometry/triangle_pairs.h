// Triangles that have an edge in common, in pairs: triangles 2k and 2k + 1 as (p, a, b) and (q, b, a). Embree holds
// such a pair as one quad, which traces faster than two triangles and takes half the hierarchy
// (testenv/benchmark/results/render_time.md).
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/geometry/mesh.h"

namespace alabaster {

/// By how many corners to turn each of two triangles to make them a pair.
struct PairTurns {
  size_t first, second;
};
/// Empty: they have no edge in common, or wind along it in the same direction.
template <class Index>
std::optional<PairTurns> turns_to_pair(const std::array<Index, 3>& first, const std::array<Index, 3>& second) {
  for (size_t i = 0; i < 3; ++i)
    for (size_t j = 0; j < 3; ++j)
      if (first[(i + 1) % 3] == second[(j + 2) % 3] && first[(i + 2) % 3] == second[(j + 1) % 3])
        return PairTurns{i, j};
  return std::nullopt;
}

template <class Index>
void turn(std::array<Index, 3>* triangle, size_t corners) {
  std::rotate(triangle->begin(), triangle->begin() + corners, triangle->end());
}

/// Makes a pair of triangles 2k and 2k + 1 wherever they have a common edge. The corners of `also`, which may be null,
/// turn with them.
template <class Index>
void pair_up(std::vector<std::array<Index, 3>>* triangles, std::vector<std::array<Index, 3>>* also = nullptr) {
  for (size_t t = 0; t + 1 < triangles->size(); t += 2) {
    const auto turns = turns_to_pair((*triangles)[t], (*triangles)[t + 1]);
    if (!turns) continue;
    for (auto* corners : {triangles, also})
      if (corners) turn(&(*corners)[t], turns->first), turn(&(*corners)[t + 1], turns->second);
  }
}

inline bool is_pair(const Corners& first, const Corners& second) {
  return first[1] == second[2] && first[2] == second[1];
}

/// True if all of them are in pairs.
inline bool are_pairs(const std::vector<Corners>& triangles) {
  if (triangles.empty() || triangles.size() % 2 != 0) return false;
  for (size_t t = 0; t < triangles.size(); t += 2)
    if (!is_pair(triangles[t], triangles[t + 1])) return false;
  return true;
}

/// The corners of both triangles, as Embree splits a quad: (v0, v1, v3) and (v2, v3, v1).
using QuadCorners = std::array<uint32_t, 4>;
inline QuadCorners quad_of(const Corners& first, const Corners& second) {
  return {first[0], first[1], second[0], first[2]};
}
inline Corners triangle_of(const QuadCorners& quad, bool second) {
  return second ? Corners{quad[2], quad[3], quad[1]} : Corners{quad[0], quad[1], quad[3]};
}

}  // namespace alabaster
