// The Pareto front: measurements that no other one beats in both cost and error.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace alabaster::tradeoff {

struct CostError {
  double cost = 0, error = 0;  // any units; less is better
};

/// Indices of the points that no other point dominates (is nowhere worse and somewhere better), by rising cost and,
/// where costs are equal, in the given order. Equal points are all chosen or all left out. A point that is not finite
/// is never chosen.
std::vector<size_t> pareto_front(std::span<const CostError> points);

}  // namespace alabaster::tradeoff
