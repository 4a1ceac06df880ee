// A binary tree of boxes that any monotonic predicate of bounds may search. bounds_tree.h, on Embree, answers queries
// of points alone.
#pragma once

#include <cstdint>
#include <vector>

#include "core/math/bounds.h"

namespace alabaster {

/// True if the boxes share a point; their sides count.
inline bool overlap(const Bounds& a, const Bounds& b) {
  for (int i = 0; i < 3; ++i)
    if (a.lower[i] > b.upper[i] || b.lower[i] > a.upper[i]) return false;
  return true;
}

/// Immutable; any thread. Built in O(n log n), and twice the size of its boxes.
class BoxTree {
 public:
  /// None of the boxes is empty.
  explicit BoxTree(std::vector<Bounds> boxes);

  size_t size() const { return boxes_.size(); }
  const Bounds& operator[](uint32_t box) const { return boxes_[box]; }

  /// Calls `visit(box)` for each box for which `admits(bounds)` is true, in no order. `admits` is called with bounds of
  /// several boxes too, and must be true of them where it is true of one.
  template <class Admits, class Visit>
  void search(const Admits& admits, const Visit& visit) const {
    if (!boxes_.empty()) search({0, 0, boxes_.size()}, admits, visit);
  }

 private:
  /// The place of the node's bounds, and the range of its boxes in order_. A node of several boxes is followed by the
  /// nodes of its first half, then by those of the second.
  struct Node {
    size_t at, begin, end;
    size_t size() const { return end - begin; }
    Node first() const { return {at + 1, begin, begin + size() / 2}; }
    Node second() const { return {at + 2 * (size() / 2), begin + size() / 2, end}; }
  };
  void build(const Node& node);
  template <class Admits, class Visit>
  void search(const Node& node, const Admits& admits, const Visit& visit) const {
    if (!admits(bounds_[node.at])) return;
    if (node.size() == 1) return visit(order_[node.begin]);
    search(node.first(), admits, visit);
    search(node.second(), admits, visit);
  }

  std::vector<Bounds> boxes_, bounds_;
  std::vector<uint32_t> order_;
};

}  // namespace alabaster
