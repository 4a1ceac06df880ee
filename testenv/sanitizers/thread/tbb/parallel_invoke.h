// Only in builds with ThreadSanitizer: see parallel_for.h. The code before happens before every function, and every
// function happens before the code after, also where one throws. Races between the functions stay visible.
#pragma once

#include_next <tbb/parallel_invoke.h>

#include <tbb/parallel_for.h>

namespace tbb {

template <class... Function>
void ordered_parallel_invoke(const Function&... functions) {
  char begin = 0, end = 0;
  __tsan_release(&begin);
  const acquire_at_exit at_exit{&end};
  const auto ordered = [&](const auto& function) {
    __tsan_acquire(&begin);
    const release_at_exit at_function_exit{&end};
    function();
  };
  tbb::parallel_invoke([&] { ordered(functions); }...);
}

}  // namespace tbb

#define parallel_invoke ordered_parallel_invoke
