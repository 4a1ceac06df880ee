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

/// Instances of an array with successive numbers, in world space. Immutable.
struct ArrayBlock {
  static constexpr size_t kSize = 1024;
  BoundsDouble bounds;      // of all that can be drawn
  PlacedSize size;          // of those together
  float least_stretch = 0;  // least_stretch(Affine) of all, of an array that scatters
  uint32_t hidden = 0;      // by their scale
  uint32_t faulty = 0;      // not finite, or beyond what can be traced
};

/// Instances that stand near each other. Immutable; another one for any edit of its instances.
struct ArrayCell {
  std::vector<uint32_t> numbers;  // increasing
};

/// An array in world space. Its instances are in blocks by number, which decide all that a picture depends on, and in
/// cells of neighbours, which are traced.
struct ArrayPlan {
  std::shared_ptr<const InstancePlaces> places;
  std::shared_ptr<const MeshPrototype> prototype;
  std::vector<std::shared_ptr<const ArrayBlock>> blocks;
  std::shared_ptr<const std::vector<uint32_t>> slots;  // InstanceCells
  std::vector<std::shared_ptr<const ArrayCell>> cells;
  size_t moved = 0;       // instances since the cells were chosen
  bool scatters = false;  // light goes below the surface

  float least_stretch() const;
};

/// `last` may be null. Blocks and cells whose instances stand as in `last` are its own. Where few instances have moved
/// since cells were chosen, each stays in its cell; which cell an instance is in changes no picture. Throws
/// BuildCancelled and MemoryRefused; `memory` may be null.
ArrayPlan plan_array(const InstanceArrayDescription& description, const ArrayPlan* last,
                     const std::shared_ptr<MemoryBudget>& memory, const CancelToken& cancel);

/// The sizes of those in a block that can be drawn, by number.
std::vector<PlacedSize> sizes_in(const ArrayPlan& plan, size_t block);

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
