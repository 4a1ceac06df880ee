#include "delegate/tradeoff/pareto.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

namespace alabaster::tradeoff {
namespace {

constexpr double kFarthest = 4;  // of a cost from those that were measured

bool is_sound(const CurvePoint& point) {
  return point.cost > 0 && std::isfinite(point.cost) && std::isfinite(point.squared_noise.value) &&
         std::isfinite(point.squared_bias.value) && point.squared_noise.value + counted(point.squared_bias) > 0;
}

double squared_error(const CurvePoint& point) {
  return point.squared_noise.value + counted(point.squared_bias);
}

/// The curves by configuration, each with its points. A point whose error is larger than that of a cheaper one of its
/// curve is left out: it has met a bright sample that the other has not.
class Curves {
 public:
  explicit Curves(std::span<const CurvePoint> points) {
    std::vector<const CurvePoint*> sound;
    for (const CurvePoint& point : points)
      if (is_sound(point)) sound.push_back(&point);
    const auto is_beaten = [&](const CurvePoint* point) {
      return std::any_of(sound.begin(), sound.end(), [&](const CurvePoint* cheaper) {
        return cheaper->configuration == point->configuration && cheaper->cost < point->cost &&
               squared_error(*cheaper) < squared_error(*point);
      });
    };
    for (const CurvePoint* point : sound)
      if (!is_beaten(point)) curves_[point->configuration].push_back(point);
  }

  /// None where the curve was not measured near `cost`.
  std::optional<Estimate> at(size_t configuration, double cost) const {
    const CurvePoint* nearest = nullptr;
    const auto distance = [&](const CurvePoint& p) { return std::abs(std::log(p.cost / cost)); };
    for (const CurvePoint* point : curves_.at(configuration))
      if (!nearest || distance(*point) < distance(*nearest)) nearest = point;
    if (distance(*nearest) > std::log(kFarthest)) return std::nullopt;
    return squared_error_at(*nearest, cost);
  }

  /// `own`: the error of `configuration` at `cost`.
  bool is_on_front(size_t configuration, double cost, const Estimate& own) const {
    for (const CurvePoint* point : curves_.at(configuration))  // its own cheaper points
      if (point->cost < cost && squared_error_at(*point, point->cost).value < own.value) return false;
    for (const auto& [other, points] : curves_) {
      if (other == configuration) continue;
      const auto error = at(other, cost);
      if (!error) continue;
      if (error->high < own.low) return false;
      if (other < configuration && !(own.high < error->low) && is_on_front(other, cost, *error)) return false;
    }
    return true;
  }

 private:
  std::map<size_t, std::vector<const CurvePoint*>> curves_;
};

}  // namespace

bool is_certain(const Estimate& squared_bias) {
  return squared_bias.value > 3 * squared_bias.standard_error;
}

double counted(const Estimate& squared_bias) {
  return is_certain(squared_bias) ? squared_bias.value : 0;
}

Estimate squared_error_at(const CurvePoint& point, double cost) {
  const double noise = point.cost / cost;
  const bool biased = is_certain(point.squared_bias);
  return {noise * point.squared_noise.value + counted(point.squared_bias),
          std::max(0.0, noise * point.squared_noise.low) + (biased ? point.squared_bias.low : 0),
          noise * point.squared_noise.high + (biased ? point.squared_bias.high : 0), 0};
}

std::vector<bool> on_front(std::span<const CurvePoint> points) {
  const Curves curves(points);
  std::vector<bool> front(points.size(), false);
  for (size_t i = 0; i < points.size(); ++i)
    if (is_sound(points[i]))
      front[i] =
          curves.is_on_front(points[i].configuration, points[i].cost, squared_error_at(points[i], points[i].cost));
  return front;
}

}  // namespace alabaster::tradeoff
