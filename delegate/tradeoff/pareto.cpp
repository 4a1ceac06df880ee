#include "delegate/tradeoff/pareto.h"

#include <algorithm>
#include <cmath>

namespace alabaster::tradeoff {

std::vector<size_t> pareto_front(std::span<const CostError> points) {
  std::vector<size_t> order;
  for (size_t i = 0; i < points.size(); ++i)
    if (std::isfinite(points[i].cost) && std::isfinite(points[i].error)) order.push_back(i);
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) {
    return points[a].cost != points[b].cost ? points[a].cost < points[b].cost : points[a].error < points[b].error;
  });
  std::vector<size_t> front;
  for (const size_t i : order) {
    if (!front.empty()) {
      const CostError &best = points[front.back()], &point = points[i];
      const bool equal = point.cost == best.cost && point.error == best.error;
      if (!equal && !(point.error < best.error)) continue;
    }
    front.push_back(i);
  }
  return front;
}

}  // namespace alabaster::tradeoff
