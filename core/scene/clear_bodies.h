// Clear bodies: instances with an interior that light passes through, and where they may touch subsurface bodies.
#pragma once

#include <vector>

#include "core/geometry/box_tree.h"
#include "core/scene/scene.h"

namespace alabaster {

bool has_clear_interior(const Instance& instance);
bool has_clear_sheets(const Instance& instance);

/// Sets Instance::clear_rank of all clear bodies, by which overlaps are decided: the body of the highest
/// interior_priority() is there. Bodies that light walks in come before other clear ones, because walks do not see
/// those. Among either, `priority` decides, then whether a clear body lies within one that light walks in (by points of
/// its mesh), then which is smaller, then the scene's index. The order in which light enters bodies must not count:
/// light that goes the other way would find another scene.
void rank_clear_bodies(SceneSnapshot* snapshot);
/// `placement` at the hit; `priority` of its material.
uint64_t interior_priority(const Instance& instance, const Placement& placement, uint32_t priority, uint32_t index);

/// Bounds of an instance that stands alone, over the whole shutter.
Bounds bounds_in_render_space(const Instance& instance);

/// Faces that coincide but for rounding count as touching.
Bounds wider(const Bounds& box);

/// Extends `all` to where one of `boxes` and one of `others` share a point; they may be the same boxes. Returns the
/// number of comparisons of boxes, in the order of n log n.
size_t extend_by_meetings(const BoxTree& boxes, const BoxTree& others, Bounds* all);

/// The boxes of a snapshot's clear bodies, in render space, and those of instances with opaque surfaces.
class ClearBoxes {
 public:
  /// The instances and the arrays of `snapshot` have been placed.
  explicit ClearBoxes(const SceneSnapshot& snapshot);

  /// Bounds of all boxes that overlap `box`, without those of the instances `left_out`, in order. Empty: none.
  Bounds that_meet(const Bounds& box, const std::vector<uint32_t>& left_out) const;

  /// Bounds of where a clear body may touch or overlap another one, or an opaque surface. Empty: none does.
  Bounds meetings() const;

 private:
  static constexpr uint32_t kNone = ~0u;

  BoxTree boxes_{{}}, opaque_{{}};
  std::vector<uint32_t> instances_;  // kNone: of an array
};

}  // namespace alabaster
