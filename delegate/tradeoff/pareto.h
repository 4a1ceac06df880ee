// Which measurements are worth having: those that nothing else beats in cost and in error at once.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace alabaster::tradeoff {

struct CostError {
  double cost = 0, error = 0;  // any units; less is better
};

/// Indices of the points that no other one dominates (nowhere worse, somewhere better), by rising cost and, where costs
/// are equal, in the given order. Equal points stand or fall together. A point that is not finite is never chosen.
std::vector<size_t> pareto_front(std::span<const CostError> points);

}  // namespace alabaster::tradeoff
