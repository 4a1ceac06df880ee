#include "core/scene/scene_origin.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace alabaster {
namespace {

bool is_too_far_from(const Vec3d& origin, const PlacedSize& p) {
  constexpr double kFarthest = 0x1p20;  // leaves 16 of a float's steps across the size
  const Vec3d below = origin - p.centers.lower, above = p.centers.upper - origin;
  const double farthest = std::max({below.x, below.y, below.z, above.x, above.y, above.z});
  return farthest > kFarthest * p.size && p.size > 0;
}

Vec3d median_center(std::span<const PlacedSize> all) {
  Vec3d median;
  std::vector<double> values(all.size());
  for (int axis = 0; axis < 3; ++axis) {
    std::transform(all.begin(), all.end(), values.begin(),
                   [axis](const PlacedSize& p) { return p.centers.center()[axis]; });
    const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    median[axis] = *middle;
  }
  return median;
}

}  // namespace

MiddleHalf middle_half(const Mesh& mesh) {
  constexpr size_t kMostPoints = 31;
  const size_t count = mesh.points.size(), used = std::min(count, kMostPoints);
  MiddleHalf middle;
  std::array<float, kMostPoints> values;
  for (int axis = 0; axis < 3; ++axis) {
    for (size_t i = 0; i < used; ++i) values[i] = mesh.points[i * count / used][axis];
    std::sort(values.begin(), values.begin() + used);
    middle.center[axis] = values[used / 2];
    middle.extent[axis] = double(values[3 * used / 4]) - double(values[used / 4]);
  }
  // Where half of the points are the same, the whole is all that there is to go by.
  if (middle.extent == Vec3d(0, 0, 0)) middle.extent = Vec3d(mesh.bounds.extent());
  return middle;
}

PlacedSize placed_size(const MiddleHalf& middle, const Matrix4d& m) {
  double squared = 0;
  for (int i = 0; i < 3; ++i) {
    const Vec3d row = Vec3d(m[i][0], m[i][1], m[i][2]) * middle.extent[i];
    squared += dot(row, row);
  }
  PlacedSize placed;
  placed.centers.extend(transform_point(middle.center, m));
  placed.size = std::sqrt(squared);
  return placed;
}

size_t count_too_far(std::span<const PlacedSize> all, const Vec3d& origin) {
  return std::accumulate(all.begin(), all.end(), size_t(0), [&](size_t sum, const PlacedSize& p) {
    return sum + (is_too_far_from(origin, p) ? p.count : 0);
  });
}

SceneOrigin choose_origin(std::span<const PlacedSize> all, const BoundsDouble& bounds) {
  SceneOrigin chosen;
  if (bounds.empty()) return chosen;
  chosen.origin = bounds.center();
  size_t fewest = count_too_far(all, chosen.origin);
  chosen.is_center = fewest == 0;
  const auto try_origin = [&](const Vec3d& origin) {
    if (fewest == 0) return;
    const size_t lost = count_too_far(all, origin);
    if (lost < fewest) chosen.origin = origin, fewest = lost;
  };
  if (fewest > 0) try_origin(median_center(all));
  constexpr size_t kMostTried = 16;
  const size_t tried = std::min(all.size(), kMostTried);
  for (size_t i = 0; i < tried; ++i) try_origin(all[i * all.size() / tried].centers.center());
  if (fewest > 0)
    for (size_t i = 0; i < all.size(); ++i)
      if (is_too_far_from(chosen.origin, all[i])) chosen.too_far.push_back(i);
  return chosen;
}

}  // namespace alabaster
