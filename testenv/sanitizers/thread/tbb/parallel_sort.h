// Only in builds with ThreadSanitizer: see parallel_for.h. The data belongs to one thread before and after, so the
// sanitizer learns nothing from a parallel sort.
#pragma once

#include <algorithm>
#include <functional>

namespace tbb {

template <class Iterator, class Less = std::less<>>
void parallel_sort(Iterator begin, Iterator end, Less less = {}) {
  std::sort(begin, end, less);
}

}  // namespace tbb
