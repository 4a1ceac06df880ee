// How the triangles of a mesh are connected: the part of its shells that does not depend on where its points are.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "core/diagnostics/cancel.h"
#include "core/memory/memory_budget.h"

namespace alabaster {

/// Corners of a triangle, after welding points by position.
using WeldedCorners = std::array<uint32_t, 3>;

/// Immutable. Triangles of one shell are connected by edges that two of them share.
struct ShellTopology {
  enum Kind : uint8_t { kSingle, kCopy, kBackToBack, kDegenerate };
  static constexpr uint32_t kNone = ~0u;
  struct Shell {
    std::vector<uint32_t> some;  // a few of its triangles
    uint32_t count = 0;
  };

  std::vector<WeldedCorners> corners;
  std::vector<Kind> kind;       // of triangles
  std::vector<bool> turned;     // of triangles: winds against the first one of its shell
  std::vector<uint32_t> shell;  // of triangles; kNone: of none
  std::vector<Shell> shells;
  std::vector<bool> open, inner;  // of shells
  bool has_walls = false;

  size_t memory_bytes() const;
};

/// Corners name points below `points`. A function of its arguments, for any number of threads. Throws BuildCancelled.
std::shared_ptr<const ShellTopology> find_shell_topology(std::vector<WeldedCorners> corners, size_t points,
                                                         const CancelToken& cancel);

/// The topology of the mesh that was asked for last. For one whose points are edited: the next one mostly has the same.
/// Any thread.
class ShellTopologyCache {
 public:
  /// `budget` counts what is held, and may be null.
  explicit ShellTopologyCache(std::shared_ptr<MemoryBudget> budget) : budget_(std::move(budget)) {}
  std::shared_ptr<const ShellTopology> get(std::vector<WeldedCorners> corners, size_t points,
                                           const CancelToken& cancel);
  void forget();

 private:
  void hold(std::shared_ptr<const ShellTopology> topology);

  const std::shared_ptr<MemoryBudget> budget_;
  std::mutex mutex_;
  std::shared_ptr<const ShellTopology> last_;
  MemoryReservation memory_;
};

}  // namespace alabaster
