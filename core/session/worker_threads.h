// Threads that render. They are not TBB's: a host, and builds of our own, keep all of those while a render runs.
#pragma once

#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

#include "core/math/float_environment.h"

namespace alabaster {

/// Calls work() on `count` threads at once, the caller's among them, and waits for all; on fewer if the system has no
/// more. Throws on the first exception that one of them left with.
template <class Work>
void run_on_threads(int count, const Work& work) {
  std::mutex mutex;
  std::exception_ptr first;
  const auto guarded = [&] {
    const FloatEnvironment environment;
    try {
      work();
    } catch (...) {
      const std::lock_guard lock(mutex);
      if (!first) first = std::current_exception();
    }
  };
  std::vector<std::jthread> others;
  try {
    while (static_cast<int>(others.size()) + 1 < count) others.emplace_back(guarded);
  } catch (const std::exception&) {
    // Neither memory nor threads are worth the frame: those that run share the work.
  }
  guarded();
  others.clear();  // joins
  if (first) std::rethrow_exception(first);
}

}  // namespace alabaster
