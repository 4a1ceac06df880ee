// A cell of instances as Embree holds it: user geometry, whose callbacks carry the ray into each instance's mesh.
// Embree as Debian builds it has one level of instances only. Internal to this room.
#pragma once

#include "core/geometry/embree_object_scene.h"
#include "core/geometry/instance_cell.h"
#include "core/geometry/ray_growth.h"

namespace alabaster {

class EmbreeInstanceCell final : public InstanceCell {
 public:
  EmbreeInstanceCell(std::shared_ptr<TraceDevice> device, std::shared_ptr<const ObjectScene> object,
                     CellInstances instances);
  /// False: it was cancelled.
  bool build(const std::function<bool()>& cancelled);

  bool is_traceable_from(float distance) const override { return growth_.allows(distance, 1); }
  size_t memory_bytes() const override;
  const EmbreeObjectScene& object() const { return static_cast<const EmbreeObjectScene&>(*object_); }
  const RayGrowth& growth() const { return growth_; }
  RTCScene get() const { return scene_.get(); }
  bool take_error() const { return scene_.take_error(); }

 private:
  static void bound(const RTCBoundsFunctionArguments* args) noexcept;
  static void intersect(const RTCIntersectFunctionNArguments* args) noexcept;
  static void occluded(const RTCOccludedFunctionNArguments* args) noexcept;

  std::shared_ptr<const ObjectScene> object_;
  RayGrowth growth_;
  SceneHandle scene_;
};

}  // namespace alabaster
