// Cancellation of long builds.
#pragma once

#include <atomic>

namespace alabaster {

/// Thrown by CancelToken::check(); no fault, so it is no std::exception.
struct BuildCancelled {};

/// Handed down into every long stretch of a build, which asks it each millisecond or so, from any of its threads. Parts
/// that are not done are dropped; those that are may be kept for the next build.
class CancelToken {
 public:
  CancelToken() = default;  // never cancelled
  /// `flag` outlives the build.
  explicit CancelToken(const std::atomic<bool>* flag) : flag_(flag) {}
  bool is_cancelled() const { return flag_ && flag_->load(std::memory_order_relaxed); }
  void check() const {
    if (is_cancelled()) throw BuildCancelled();
  }

 private:
  const std::atomic<bool>* flag_ = nullptr;
};

/// std::less for sorts that may be cancelled.
struct CancellableLess {
  const CancelToken& cancel;
  template <class T>
  bool operator()(const T& a, const T& b) const {
    cancel.check();
    return a < b;
  }
};

}  // namespace alabaster
