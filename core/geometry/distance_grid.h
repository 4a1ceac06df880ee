// Lower bounds of the distance to a mesh, looked up in tens of nanoseconds: voxels that the surface may touch, then an
// exact Euclidean distance transform between voxels (Felzenszwalb and Huttenlocher 2012, "Distance Transforms of
// Sampled Functions": linear in the number of voxels). A closest-point query costs as much as 7 to 300 rays, and the
// walk that asks needs no more than a bound.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "core/geometry/mesh.h"

namespace alabaster {

/// Immutable; asked from any thread. Object space of the mesh it was built from.
class DistanceGrid {
 public:
  /// No point of the surface is nearer to `p`; 0 outside the mesh's bounds and in and beside the voxels that the
  /// surface touches. Misses the true distance by two voxels' diagonals at most.
  float bound(const Vec3f& p) const {
    const Vec3f q = (p - lower_) * voxels_per_unit_;
    if (!(q.x >= 0 && q.y >= 0 && q.z >= 0)) return 0;  // NaN too
    if (!(q.x < size_f_.x && q.y < size_f_.y && q.z < size_f_.z)) return 0;
    const auto x = static_cast<uint32_t>(q.x), y = static_cast<uint32_t>(q.y), z = static_cast<uint32_t>(q.z);
    return static_cast<float>(cells_[(size_t(z) * size_[1] + y) * size_[0] + x]) * units_per_step_;
  }
  float voxel() const { return 1 / voxels_per_unit_; }
  size_t memory_bytes() const { return cells_.size(); }

 private:
  friend std::shared_ptr<const DistanceGrid> build_distance_grid(const Mesh& mesh, uint32_t resolution);

  Vec3f lower_{0, 0, 0}, size_f_{0, 0, 0};
  float voxels_per_unit_ = 0, units_per_step_ = 0;
  uint32_t size_[3] = {0, 0, 0};
  std::vector<uint8_t> cells_;  // in quarters of a voxel, rounded down; x fastest
};

/// `resolution` voxels (1..255) along the longest side of the mesh's bounds, at most resolution^3 bytes. Builds with
/// the threads of the caller's task arena. Null for a mesh without extent, and for one that would take long: a heap of
/// triangles that each cross much of the whole.
std::shared_ptr<const DistanceGrid> build_distance_grid(const Mesh& mesh, uint32_t resolution);

/// The grid of a mesh that many snapshots share: built when first asked for. Any thread.
class LazyDistanceGrid {
 public:
  /// `mesh` must be the same each time.
  const DistanceGrid* get(const Mesh& mesh);

 private:
  std::mutex mutex_;
  bool built_ = false;
  std::shared_ptr<const DistanceGrid> grid_;
};

}  // namespace alabaster
