#include "core/session/deferred_notifier.h"

namespace alabaster {

void DeferredNotifier::request() {
  if (!requested_) due_ = Clock::now() + grace_;
  requested_ = true;
  if (pollers_ == 0) notify();
}

// If several threads see one request, one of them notifies.
void DeferredNotifier::notify() {
  if (requested_.exchange(false)) notify_();
}

void DeferredNotifier::begin_work() {
  const std::lock_guard lock(mutex_);
  working_ = core_wanted_ = true;
}

void DeferredNotifier::end_work() {
  {
    const std::lock_guard lock(mutex_);
    working_ = core_wanted_ = false;
  }
  work_ended_.notify_all();
}

void DeferredNotifier::yield_core(const std::atomic<bool>& stopped) {
  if (!core_wanted_.exchange(false)) return;
  constexpr std::chrono::milliseconds kLook(2), kLongest(30);  // a user does not wait for the edits of longer work
  const Clock::time_point until = Clock::now() + kLongest;
  const PollingPause pause(this);
  std::unique_lock lock(mutex_);
  while (working_ && !stopped && Clock::now() < until) work_ended_.wait_for(lock, kLook);
}

void DeferredNotifier::add_poller() {
  ++pollers_;
}

// The count falls before notify() reads the flag: either this thread sees the request, or request() sees that no thread
// polls.
void DeferredNotifier::remove_poller() {
  if (--pollers_ == 0) notify();
}

}  // namespace alabaster
