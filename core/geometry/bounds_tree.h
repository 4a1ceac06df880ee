// Finds, among many boxes, those that hold a point.
#pragma once

#include <memory>
#include <vector>

#include "core/geometry/embree_scene.h"
#include "core/math/bounds.h"

namespace alabaster {

/// A BVH of boxes. Immutable; any thread.
class BoundsTree {
 public:
  /// Called with the index of a box; true: no other need be looked at. Must not throw.
  using Visit = bool (*)(void* data, uint32_t box);

  virtual ~BoundsTree() = default;
  /// Visits boxes that hold `p`, in no order; true if a visit was. The cost is logarithmic in the number of boxes,
  /// times those that hold the point.
  virtual bool any_at(const Vec3f& p, Visit visit, void* data) const = 0;
  /// `visit(box)` as above.
  template <class F>
  bool any_at(const Vec3f& p, F&& visit) const {
    return any_at(
        p, [](void* data, uint32_t box) { return (*static_cast<F*>(data))(box); }, &visit);
  }
};

/// Null and exceptions as those of build_object_scene().
std::shared_ptr<const BoundsTree> build_bounds_tree(const std::shared_ptr<TraceDevice>& device,
                                                    std::vector<Bounds> boxes,
                                                    const std::function<bool()>& cancelled = {});

}  // namespace alabaster
