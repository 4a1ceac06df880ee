// Instances of one mesh that stand near each other, traced as one thing: an array of many instances is made of such
// cells. An edit of some instances builds their cells again, and no others.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "core/geometry/placement.h"
#include "core/memory/memory_budget.h"

namespace alabaster {

class ObjectScene;
class TraceDevice;

struct CellInstances {
  std::shared_ptr<const std::vector<uint32_t>> numbers;  // in the array, increasing; not null
  std::vector<Placement> placements;                     // parallel
  std::vector<bool> hidden;                              // parallel: never hit
  MemoryReservation memory = {};
};

/// Immutable; traced from any thread, through the InstancedScene that has it.
class InstanceCell {
 public:
  explicit InstanceCell(CellInstances instances) : instances_(std::move(instances)) {}
  virtual ~InstanceCell() = default;
  const CellInstances& instances() const { return instances_; }
  /// True if rays of unit direction that start within `distance` of the origin may be traced through all that is not
  /// hidden.
  virtual bool is_traceable_from(float distance) const = 0;
  virtual size_t memory_bytes() const = 0;

 protected:
  CellInstances instances_;
};

/// All that is not hidden must be traceable, see is_traceable(). `object` does not deform. Null and exceptions as
/// those of build_object_scene().
std::shared_ptr<const InstanceCell> build_instance_cell(const std::shared_ptr<TraceDevice>& device,
                                                        std::shared_ptr<const ObjectScene> object,
                                                        CellInstances instances,
                                                        const std::function<bool()>& cancelled = {});

/// The cells of an array, and where each instance is in them.
struct InstanceCells {
  static constexpr uint32_t kMost = 1024;                  // instances of a cell
  std::vector<std::shared_ptr<const InstanceCell>> cells;  // not null
  std::shared_ptr<const std::vector<uint32_t>> slots;      // by number: cell * kMost + index in the cell

  size_t size() const { return slots ? slots->size() : 0; }
  const Placement& placement(uint32_t number) const {
    const uint32_t slot = (*slots)[number];
    return cells[slot / kMost]->instances().placements[slot % kMost];
  }
};

}  // namespace alabaster
