// Arrays of instances: many that are alike but for where they stand. An edit of some costs the cells that they are in,
// and nothing is held for an instance but its placement, its number and its share of the hierarchy.
#pragma once

#include <memory>
#include <vector>

#include "core/diagnostics/cancel.h"
#include "core/geometry/embree_scene.h"
#include "core/math/bounds.h"
#include "core/memory/memory_budget.h"
#include "core/scene/instance_places.h"
#include "core/scene/scene_origin.h"

namespace alabaster {

struct MeshPrototype;
struct InstanceArrayDescription;

/// A cell in world space. Immutable.
struct ArrayCell {
  std::shared_ptr<const std::vector<uint32_t>> numbers;  // in the array, increasing
  BoundsDouble bounds;                                   // of all that can be drawn
  BoundsDouble centers;                                  // of the middles of their meshes, see PlacedSize
  double least_size = 0;                                 // of theirs
  float least_stretch = 0;                               // least_stretch(Affine) of all, of an array that scatters
  uint32_t drawn = 0;
  uint32_t hidden = 0;  // by a scale of zero
  uint32_t faulty = 0;  // not finite, or beyond what can be traced
};

/// An array in world space: its instances in cells of neighbours.
struct ArrayPlan {
  std::shared_ptr<const InstancePlaces> places;
  std::shared_ptr<const MeshPrototype> prototype;
  std::shared_ptr<const std::vector<uint32_t>> slots;  // InstanceCells
  std::vector<std::shared_ptr<const ArrayCell>> cells;
  size_t moved = 0;       // instances since the cells were chosen
  bool scatters = false;  // light goes below the surface

  float least_stretch() const;
};

/// `last` may be null. Cells whose instances stand as in `last` are its own. Where few instances have moved since cells
/// were chosen, each stays in its cell; which cell an instance is in changes no picture. Throws BuildCancelled.
ArrayPlan plan_array(const InstanceArrayDescription& description, const ArrayPlan* last, const CancelToken& cancel);

/// Those of the instances that can be drawn, in order.
std::vector<PlacedSize> sizes_in(const ArrayPlan& plan, const ArrayCell& cell);

struct RenderSpace {
  Vec3d origin{0, 0, 0};
  float farthest = 0;  // rays that start within this distance of the origin are traced
};

/// An array as it is traced. Immutable.
struct PlacedArray {
  ArrayPlan plan;
  RenderSpace space;
  InstanceCells traced;
  std::vector<uint32_t> left_out;  // by cell: instances too small, flat or large to be traced from there

  size_t size() const { return traced.size(); }
  Bounds bounds() const;  // in render space, rounded outwards
  size_t memory_bytes() const;
};

/// Says how many cannot be placed or traced. True if that is a fault: some are not hidden by their scale.
bool report_left_out(const PlacedArray& array, const std::string& name, const DiagnosticSink& sink);

/// Shares the cells of `last` (may be null) that are placed alike. Null when memory runs out or Embree refuses
/// (reported). Throws BuildCancelled and MemoryRefused.
std::shared_ptr<const PlacedArray> place_array(ArrayPlan plan, const RenderSpace& space, const PlacedArray* last,
                                               const std::shared_ptr<TraceDevice>& device, const CancelToken& cancel);

}  // namespace alabaster
