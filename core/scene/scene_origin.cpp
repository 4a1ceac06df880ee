#include "core/scene/scene_origin.h"

#include <algorithm>

namespace alabaster {
namespace {

// The middle half of a mesh's points along each axis: a few stray points do not change it.
struct MiddleHalf {
  Vec3d center{0, 0, 0}, extent{0, 0, 0};
};

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

struct PlacedSize {
  Vec3d center{0, 0, 0};
  double size = 0;

  bool is_too_far_from(const Vec3d& origin) const {
    constexpr double kFarthest = 0x1p20;  // leaves 16 of a float's steps across the size
    const Vec3d d = center - origin;
    return std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)}) > kFarthest * size && size > 0;
  }
};

// Instances of one mesh come one after the other.
std::vector<PlacedSize> placed_sizes(std::span<const InstanceDescription* const> drawn) {
  std::vector<PlacedSize> all;
  all.reserve(drawn.size());
  MiddleHalf middle;
  const MeshPrototype* last = nullptr;
  for (const InstanceDescription* d : drawn) {
    if (d->prototype.get() != last) middle = middle_half(d->prototype->mesh), last = d->prototype.get();
    const Matrix4d& m = d->object_to_world;
    double squared = 0;
    for (int i = 0; i < 3; ++i) {
      const Vec3d row = Vec3d(m[i][0], m[i][1], m[i][2]) * middle.extent[i];
      squared += dot(row, row);
    }
    all.push_back({transform_point(middle.center, m), std::sqrt(squared)});
  }
  return all;
}

Vec3d median_center(const std::vector<PlacedSize>& all) {
  Vec3d median;
  std::vector<double> values(all.size());
  for (int axis = 0; axis < 3; ++axis) {
    std::transform(all.begin(), all.end(), values.begin(), [axis](const PlacedSize& p) { return p.center[axis]; });
    const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    median[axis] = *middle;
  }
  return median;
}

}  // namespace

SceneOrigin choose_origin(std::span<const InstanceDescription* const> drawn, const BoundsDouble& bounds) {
  SceneOrigin chosen;
  if (bounds.empty()) return chosen;
  const std::vector<PlacedSize> all = placed_sizes(drawn);
  const auto count_lost = [&all](const Vec3d& origin) {
    return std::count_if(all.begin(), all.end(), [&](const PlacedSize& p) { return p.is_too_far_from(origin); });
  };
  chosen.origin = bounds.center();
  auto fewest = count_lost(chosen.origin);
  const auto try_origin = [&](const Vec3d& origin) {
    if (fewest == 0) return;
    const auto lost = count_lost(origin);
    if (lost < fewest) chosen.origin = origin, fewest = lost;
  };
  if (fewest > 0) try_origin(median_center(all));
  constexpr size_t kMostTried = 16;
  const size_t tried = std::min(all.size(), kMostTried);
  for (size_t i = 0; i < tried; ++i) try_origin(all[i * all.size() / tried].center);
  if (fewest > 0)
    for (size_t i = 0; i < all.size(); ++i)
      if (all[i].is_too_far_from(chosen.origin)) chosen.too_far.push_back(drawn[i]);
  return chosen;
}

}  // namespace alabaster
