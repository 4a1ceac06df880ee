// Lower bounds of the distance to a mesh, looked up in tens of nanoseconds: voxels that the surface may touch, then an
// exact Euclidean distance transform between voxels (Felzenszwalb and Huttenlocher 2012, "Distance Transforms of
// Sampled Functions": linear in the number of voxels). A closest-point query costs as much as 7 to 300 rays, and the
// walk that asks needs no more than a bound.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/geometry/mesh.h"

namespace alabaster {

/// Immutable; asked from any thread. Object space of the mesh it was built from.
class DistanceGrid {
 public:
  /// No point of the surface is nearer to `p`; 0 outside the mesh's bounds and near the voxels that the surface
  /// touches. Misses the true distance by less than two voxels on average, by four at most.
  float bound(const Vec3f& p) const {
    const Vec3f q = (p - lower_) * voxels_per_unit_;
    if (!(q.x >= 0 && q.y >= 0 && q.z >= 0)) return 0;  // NaN too
    if (!(q.x < size_f_.x && q.y < size_f_.y && q.z < size_f_.z)) return 0;
    const auto x = static_cast<uint32_t>(q.x), y = static_cast<uint32_t>(q.y), z = static_cast<uint32_t>(q.z);
    const uint8_t cell = cells_[(size_t(z) * size_[1] + y) * size_[0] + x];
    if (cell == 0) return 0;
    // Distances are stored for voxel centres.
    const Vec3f off = q - Vec3f(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)) - Vec3f(0.5f);
    return std::max(0.0f, 0.25f * static_cast<float>(cell) - length(off) - kRounding) * unit_per_voxel_;
  }
  size_t memory_bytes() const { return cells_.size(); }

 private:
  static constexpr float kRounding = 1e-4f;  // in voxels: more than that of q in a grid of 255

  friend std::shared_ptr<const DistanceGrid> build_distance_grid(const Mesh& mesh, uint32_t resolution,
                                                                 const CancelToken& cancel);

  Vec3f lower_{0, 0, 0}, size_f_{0, 0, 0};
  float voxels_per_unit_ = 0, unit_per_voxel_ = 0;
  uint32_t size_[3] = {0, 0, 0};
  std::vector<uint8_t> cells_;  // in quarters of a voxel, rounded down; x fastest
};

/// `resolution` voxels (1..255) along the longest side of the mesh's bounds, at most resolution^3 bytes. Builds with
/// the threads of the caller's task arena. Null for a mesh without extent, and for one that would take long: a heap of
/// triangles that each cross much of the whole. Throws BuildCancelled.
std::shared_ptr<const DistanceGrid> build_distance_grid(const Mesh& mesh, uint32_t resolution,
                                                        const CancelToken& cancel = {});

}  // namespace alabaster
