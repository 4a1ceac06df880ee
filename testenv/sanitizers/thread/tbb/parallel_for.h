// Only in builds with ThreadSanitizer. Debian's libtbb is not instrumented: the sanitizer sees its tasks on several
// threads but nothing that orders them, and takes every hand-over of data for a race. This header tells it the order
// that tbb::parallel_for promises: the code before the loop happens before every task, and every task happens before
// the code after the loop, also where one throws. Races between tasks of one loop stay visible.
#pragma once

#include_next <tbb/parallel_for.h>

extern "C" void __tsan_acquire(void* address);
extern "C" void __tsan_release(void* address);

namespace tbb {

struct release_at_exit {
  char* address;
  ~release_at_exit() { __tsan_release(address); }
};
struct acquire_at_exit {
  char* address;
  ~acquire_at_exit() { __tsan_acquire(address); }
};

template <class Body>
struct ordered_body {
  const Body& body;
  char* begin;
  char* end;
  template <class Range>
  void operator()(Range&& range) const {
    __tsan_acquire(begin);
    const release_at_exit at_exit{end};
    body(range);
  }
};

template <class Loop, class Body>
void run_ordered(const Loop& loop, const Body& body) {
  char begin = 0, end = 0;
  __tsan_release(&begin);
  const acquire_at_exit at_exit{&end};
  loop(ordered_body<Body>{body, &begin, &end});
}

template <class Range, class Body>
void ordered_parallel_for(const Range& range, const Body& body) {
  run_ordered([&](const auto& ordered) { tbb::parallel_for(range, ordered); }, body);
}

template <class Index, class Body, class... Partitioner>
void ordered_parallel_for(Index first, Index last, const Body& body, Partitioner&&... partitioner) {
  run_ordered([&](const auto& ordered) { tbb::parallel_for(first, last, ordered, partitioner...); }, body);
}

}  // namespace tbb

#define parallel_for ordered_parallel_for
