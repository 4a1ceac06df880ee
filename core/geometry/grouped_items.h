// A counting sort, by which triangles of a mesh find the others at the same point or edge.
#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "core/diagnostics/cancel.h"

namespace alabaster {

/// Items in numbered groups, each group sorted by `<`. Linear time where groups are small; a large group is sorted as
/// any array is, so that no input makes it slow. The same for any number of threads.
template <class Item>
class GroupedItems {
 public:
  /// `each(add)` calls add(group, item) for every item; it runs twice and must do the same both times. Throws
  /// BuildCancelled.
  template <class Each>
  GroupedItems(size_t groups, const Each& each, const CancelToken& cancel) : begin_(groups + 2, 0) {
    // Group g is counted at g + 2. After the sums it begins at begin_[g + 1], which moves to its end while it is
    // filled.
    each([&](size_t group, const Item&) { ++begin_[group + 2]; });
    for (size_t g = 2; g < begin_.size(); ++g) begin_[g] += begin_[g - 1];
    cancel.check();
    items_.reserve(begin_.back());
    constexpr size_t kStep = 65536;  // the first touch of memory takes longer than all else here
    while (items_.size() < begin_.back()) {
      cancel.check();
      items_.resize(std::min(begin_.back(), items_.size() + kStep));
    }
    each([&](size_t group, const Item& item) { items_[begin_[group + 1]++] = item; });
    cancel.check();
    tbb::parallel_for(tbb::blocked_range<size_t>(0, groups, 256), [&](const tbb::blocked_range<size_t>& range) {
      for (size_t g = range.begin(); g < range.end(); ++g)
        tbb::parallel_sort(items_.begin() + offset(g), items_.begin() + offset(g + 1), CancellableLess{cancel});
    });
  }

  size_t size() const { return begin_.size() - 2; }
  std::span<const Item> operator[](size_t group) const {
    return {items_.data() + begin_[group], items_.data() + begin_[group + 1]};
  }

 private:
  std::ptrdiff_t offset(size_t group) const { return static_cast<std::ptrdiff_t>(begin_[group]); }

  std::vector<size_t> begin_;  // of each group, and the end of the last
  std::vector<Item> items_;
};

/// Calls visit(run) for each run of items of a group that are `alike`, in their order.
template <class Item, class Alike, class Visit>
void for_each_run(std::span<const Item> group, const Alike& alike, const Visit& visit) {
  for (size_t i = 0, end = 0; i < group.size(); i = end) {
    for (end = i + 1; end < group.size() && alike(group[i], group[end]); ++end) {
    }
    visit(group.subspan(i, end - i));
  }
}

}  // namespace alabaster
