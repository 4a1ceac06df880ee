#include "core/geometry/box_tree.h"

#include <algorithm>
#include <numeric>

namespace alabaster {
namespace {

int longest_axis(const Bounds& bounds) {
  const Vec3f e = bounds.extent();
  return e.x >= e.y && e.x >= e.z ? 0 : e.y >= e.z ? 1 : 2;
}

}  // namespace

BoxTree::BoxTree(std::vector<Bounds> boxes) : boxes_(std::move(boxes)), order_(boxes_.size()) {
  std::iota(order_.begin(), order_.end(), 0u);
  if (boxes_.empty()) return;
  bounds_.resize(2 * boxes_.size() - 1);
  build({0, 0, boxes_.size()});
}

void BoxTree::build(const Node& node) {
  const auto at = [&](size_t i) { return order_.begin() + static_cast<std::ptrdiff_t>(i); };
  Bounds centres;
  for (size_t i = node.begin; i < node.end; ++i) {
    bounds_[node.at].extend(boxes_[order_[i]]);
    centres.extend(boxes_[order_[i]].center());
  }
  if (node.size() == 1) return;
  const int axis = longest_axis(centres);
  std::nth_element(at(node.begin), at(node.second().begin), at(node.end),
                   [&](uint32_t a, uint32_t b) { return boxes_[a].center()[axis] < boxes_[b].center()[axis]; });
  build(node.first());
  build(node.second());
}

}  // namespace alabaster
