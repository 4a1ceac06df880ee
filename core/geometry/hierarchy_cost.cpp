#include "core/geometry/hierarchy_cost.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <utility>

namespace alabaster {
namespace {

constexpr size_t kGroup = 8;

// The bits of a number of ten bits, two zeros between any two.
uint32_t spread_bits(uint32_t x) {
  x = (x | x << 16) & 0x030000ff;
  x = (x | x << 8) & 0x0300f00f;
  x = (x | x << 4) & 0x030c30c3;
  return (x | x << 2) & 0x09249249;
}

// The place on a curve that stays near itself (Morton 1966).
uint32_t place_on_curve(const Vec3f& p, const Bounds& bounds) {
  const Vec3f extent = bounds.extent();
  const auto bits = [](float at, float lower, float length) {
    const float share = length > 0 ? (at - lower) / length : 0;
    return spread_bits(static_cast<uint32_t>(std::clamp(share, 0.0f, 1.0f) * 1023));
  };
  return bits(p.x, bounds.lower.x, extent.x) << 2 | bits(p.y, bounds.lower.y, extent.y) << 1 |
         bits(p.z, bounds.lower.z, extent.z);
}

double surface(const Bounds& bounds) {
  const Vec3d e(bounds.extent());
  return 2 * (e.x * e.y + e.y * e.z + e.z * e.x);
}

template <class Visit>
void for_each_in_parallel(size_t count, const Visit& visit) {
  tbb::parallel_for(tbb::blocked_range<size_t>(0, count, 512), [&](const tbb::blocked_range<size_t>& range) {
    for (size_t i = range.begin(); i < range.end(); ++i) visit(i);
  });
}

}  // namespace

TriangleGroups::TriangleGroups(const Mesh& mesh, const CancelToken& cancel) {
  std::vector<std::pair<uint32_t, uint32_t>> placed(mesh.triangles.size());
  for_each_in_parallel(placed.size(), [&](size_t i) {
    const Corners& c = mesh.triangles[i];
    const Vec3f middle = (mesh.points[c[0]] + mesh.points[c[1]] + mesh.points[c[2]]) / 3.0f;
    placed[i] = {place_on_curve(middle, mesh.bounds), static_cast<uint32_t>(i)};
  });
  tbb::parallel_sort(placed.begin(), placed.end(), CancellableLess{cancel});
  order_.reserve(placed.size());
  for (const auto& [place, triangle] : placed) order_.push_back(triangle);
}

double TriangleGroups::cost(const Mesh& mesh) const {
  std::vector<Bounds> boxes((order_.size() + kGroup - 1) / kGroup);
  for_each_in_parallel(boxes.size(), [&](size_t group) {
    for (size_t i = kGroup * group; i < std::min(kGroup * (group + 1), order_.size()); ++i)
      for (const uint32_t corner : mesh.triangles[order_[i]]) boxes[group].extend(mesh.points[corner]);
  });
  double sum = 0;
  while (boxes.size() > 1) {
    for (const Bounds& box : boxes) sum += surface(box);
    for (size_t i = 0; i < boxes.size(); ++i) {
      const Bounds box = boxes[i];
      if (i % kGroup == 0) boxes[i / kGroup] = Bounds();
      boxes[i / kGroup].extend(box.lower), boxes[i / kGroup].extend(box.upper);
    }
    boxes.resize((boxes.size() + kGroup - 1) / kGroup);
  }
  const double whole = boxes.empty() ? 0 : surface(boxes.front());
  return whole > 0 ? sum / whole : 0;
}

}  // namespace alabaster
