#include "core/session/wake_relay.h"

namespace alabaster {

void WakeRelay::ask() {
  if (!asked_) due_ = Clock::now() + grace_;
  asked_ = true;
  if (carriers_ == 0) wake();
}

// If several see one ask(), one of them wakes.
void WakeRelay::wake() {
  if (asked_.exchange(false)) wake_();
}

void WakeRelay::begin_work() {
  const std::lock_guard lock(mutex_);
  working_ = core_wanted_ = true;
}

void WakeRelay::end_work() {
  {
    const std::lock_guard lock(mutex_);
    working_ = core_wanted_ = false;
  }
  work_ended_.notify_all();
}

void WakeRelay::lend_core(const std::atomic<bool>& stopped) {
  if (!core_wanted_.exchange(false)) return;
  constexpr std::chrono::milliseconds kLook(2), kLongest(30);  // longer work is no edit that a user waits for
  const Clock::time_point until = Clock::now() + kLongest;
  const Rest rest(this);
  std::unique_lock lock(mutex_);
  while (working_ && !stopped && Clock::now() < until) work_ended_.wait_for(lock, kLook);
}

void WakeRelay::take_up() {
  ++carriers_;
}

// The count falls before the look: either this sees what ask() did, or ask() sees that nobody carries.
void WakeRelay::lay_down() {
  if (--carriers_ == 0) wake();
}

}  // namespace alabaster
