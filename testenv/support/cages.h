// Small cages that several tests share, and a sink that keeps its diagnostics.
#pragma once

#include <algorithm>
#include <mutex>
#include <string>
#include <vector>

#include "core/geometry/cage.h"

namespace alabaster::test {

/// The cube [-1, 1]^3: points by bits x + 2y + 4z, six quads wound counter-clockwise from outside.
inline Cage cube_cage(SubdivisionScheme scheme = SubdivisionScheme::none) {
  Cage cage;
  cage.scheme = scheme;
  for (int i = 0; i < 8; ++i)
    cage.points.emplace_back(i & 1 ? 1.0f : -1.0f, i & 2 ? 1.0f : -1.0f, i & 4 ? 1.0f : -1.0f);
  cage.face_vertex_counts.assign(6, 4);
  cage.face_vertex_indices = {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5};
  return cage;
}

/// A flat grid of n x n unit quads in z = 0, facing +z; points row by row.
inline Cage grid_cage(int n, SubdivisionScheme scheme = SubdivisionScheme::none) {
  Cage cage;
  cage.scheme = scheme;
  for (int y = 0; y <= n; ++y)
    for (int x = 0; x <= n; ++x) cage.points.emplace_back(static_cast<float>(x), static_cast<float>(y), 0.0f);
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) {
      const int a = y * (n + 1) + x;
      cage.face_vertex_counts.push_back(4);
      cage.face_vertex_indices.insert(cage.face_vertex_indices.end(), {a, a + 1, a + n + 2, a + n + 1});
    }
  return cage;
}

/// A regular octahedron with vertices at distance 1: eight triangles.
inline Cage octahedron_cage(SubdivisionScheme scheme = SubdivisionScheme::none) {
  Cage cage;
  cage.scheme = scheme;
  cage.points = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  cage.face_vertex_counts.assign(8, 3);
  cage.face_vertex_indices = {0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5};
  return cage;
}

/// A prism over a pentagon: two 5-gons and five quads.
inline Cage pentagon_prism_cage(SubdivisionScheme scheme = SubdivisionScheme::none) {
  Cage cage;
  cage.scheme = scheme;
  for (int z = 0; z < 2; ++z)
    for (int i = 0; i < 5; ++i) {
      const float angle = kTwoPi * static_cast<float>(i) / 5;
      cage.points.emplace_back(std::cos(angle), std::sin(angle), static_cast<float>(z));
    }
  cage.face_vertex_counts = {5, 5, 4, 4, 4, 4, 4};
  cage.face_vertex_indices = {4, 3, 2, 1, 0, 5, 6, 7, 8, 9};
  for (int i = 0; i < 5; ++i) {
    const int j = (i + 1) % 5;
    cage.face_vertex_indices.insert(cage.face_vertex_indices.end(), {i, j, j + 5, i + 5});
  }
  return cage;
}

/// Keeps every diagnostic; usable from any thread.
class RecordingSink {
 public:
  DiagnosticSink sink() {
    return [this](const Diagnostic& d) {
      const std::lock_guard<std::mutex> lock(mutex_);
      diagnostics_.push_back(d);
    };
  }
  bool has(const std::string& code) const {
    return std::any_of(diagnostics_.begin(), diagnostics_.end(), [&](const Diagnostic& d) { return d.code == code; });
  }
  const std::vector<Diagnostic>& all() const { return diagnostics_; }

 private:
  std::mutex mutex_;
  std::vector<Diagnostic> diagnostics_;
};

}  // namespace alabaster::test
