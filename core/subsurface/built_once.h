// A part that is built when it is first asked for, by parallel loops.
#pragma once

#include <tbb/task_arena.h>

#include <atomic>
#include <mutex>
#include <optional>

namespace alabaster {

/// Any thread. The build runs under a lock; a thread that waits for its own parallel loop in there must not take up
/// another task meanwhile, because that task may ask for this very part and would then wait for its own thread without
/// end. So the build is isolated.
template <class T>
class BuiltOnce {
 public:
  /// `build()` must give the same at each call. When it throws, the next call builds again.
  template <class Build>
  const T& get(const Build& build) {
    if (const T* built = built_.load(std::memory_order_acquire)) return *built;
    const std::scoped_lock lock(mutex_);
    if (!part_) tbb::this_task_arena::isolate([&] { part_.emplace(build()); });
    built_.store(&*part_, std::memory_order_release);
    return *part_;
  }
  bool is_built() const { return built_.load(std::memory_order_acquire) != nullptr; }
  /// `measure(part)`, or 0 if it is not built.
  template <class Measure>
  size_t measured(const Measure& measure) {
    const std::scoped_lock lock(mutex_);
    return part_ ? measure(*part_) : 0;
  }

 private:
  std::mutex mutex_;
  std::optional<T> part_;
  std::atomic<const T*> built_ = nullptr;
};

}  // namespace alabaster
