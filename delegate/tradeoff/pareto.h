// The front of error against cost: measurements that nothing cheaper beats, and that beat the base.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "delegate/tradeoff/measurement.h"

namespace alabaster::tradeoff {

/// A measurement of a configuration. Its curve continues from there: error^2 = bias^2 + noise^2, where noise^2 falls as
/// the cost rises and bias^2 stays.
struct CurvePoint {
  size_t configuration = 0;  // 0: the base. The first of several that are equally good counts
  double cost = 0;           // > 0
  Estimate squared_noise;    // at that cost, with the uncertainty of the cost
  Estimate squared_bias;
};

/// False for a bias that may be zero: within three standard errors, so that hardly one in a study of many
/// configurations seems biased by chance.
bool is_certain(const Estimate& squared_bias);
/// A bias that may be zero counts as zero.
double counted(const Estimate& squared_bias);

/// error^2 of the point's curve at `cost`, with its interval.
Estimate squared_error_at(const CurvePoint& point, double cost);

/// True for the points of the front. A point is on it if no other configuration's error is smaller at its cost, beyond
/// both intervals, and if its own is smaller, beyond both intervals, than those of all configurations before its own
/// that are on the front at that cost; the base, which is before all, has only to be unbeaten. A cheaper point of the
/// same configuration must not have a smaller error. Curves are not followed beyond four times their costs, either way.
/// A point whose cost or error is not finite and positive is never on the front.
std::vector<bool> on_front(std::span<const CurvePoint> points);

}  // namespace alabaster::tradeoff
