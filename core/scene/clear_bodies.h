// Clear bodies: instances with an interior that light passes through, and where they may touch subsurface bodies.
#pragma once

#include <vector>

#include "core/scene/scene.h"

namespace alabaster {

bool has_clear_interior(const Instance& instance);

/// Bounds of an instance that stands alone, over the whole shutter.
Bounds bounds_in_render_space(const Instance& instance);

/// True if the boxes share a point; their sides count.
bool overlap(const Bounds& a, const Bounds& b);

/// The boxes of a snapshot's clear bodies, in render space.
class ClearBoxes {
 public:
  /// The instances and the arrays of `snapshot` have been placed.
  explicit ClearBoxes(const SceneSnapshot& snapshot);

  /// Bounds of all boxes that overlap `box`, without those of the instances `left_out`. Empty: none.
  Bounds that_meet(const Bounds& box, const std::vector<uint32_t>& left_out) const;

 private:
  struct Box {
    Bounds bounds;
    uint32_t instance;  // kNone: of several
  };
  static constexpr uint32_t kNone = ~0u;

  std::vector<Box> boxes_;
};

}  // namespace alabaster
