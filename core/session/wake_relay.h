// Render threads notify the builder's thread, and one of them yields its core to it.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <utility>

namespace alabaster {

/// A notification can cost the calling thread its core for 6 to 12 ms while all cores are busy (Linux 6.18;
/// edit_latency). A host's thread therefore sets a flag, which render threads poll before each sample, and one of them
/// notifies. Where no thread renders, cores are free, and the caller notifies.
class WakeRelay {
 public:
  using Clock = std::chrono::steady_clock;
  /// `wake` is called on any thread, on several at once, and must not throw. A carrier waits with it for `grace`: the
  /// thread that wakes up may take the core of the one that has asked, which should be done by then.
  explicit WakeRelay(std::function<void()> wake, Clock::duration grace) : wake_(std::move(wake)), grace_(grace) {}

  void ask();

  /// The owner's thread works between these calls, which are its own.
  void begin_work();
  void end_work();
  bool wants_core() const { return core_wanted_.load(std::memory_order_relaxed); }
  /// Called by a thread that renders where there are no more cores than such threads. The first one since begin_work()
  /// returns once the work has ended, `stopped` is true, or 30 ms have passed; others return at once.
  void lend_core(const std::atomic<bool>& stopped);

  /// While it lives, its thread calls pass_on() again and again. Null: there is nothing to carry.
  class Carrier {
   public:
    explicit Carrier(WakeRelay* relay) : relay_(relay) {
      if (relay_) relay_->take_up();
    }
    ~Carrier() {
      if (relay_) relay_->lay_down();
    }
    Carrier(const Carrier&) = delete;
    Carrier& operator=(const Carrier&) = delete;
    void pass_on() const {
      if (relay_) relay_->pass_on();
    }

   private:
    WakeRelay* const relay_;
  };

  /// While it lives, its thread, which is a Carrier's, waits and passes nothing on.
  class Rest {
   public:
    explicit Rest(WakeRelay* relay) : relay_(relay) {
      if (relay_) relay_->lay_down();
    }
    ~Rest() {
      if (relay_) relay_->take_up();
    }
    Rest(const Rest&) = delete;
    Rest& operator=(const Rest&) = delete;

   private:
    WakeRelay* const relay_;
  };

 private:
  void pass_on() {
    if (asked_ && Clock::now() >= due_.load()) wake();
  }
  void take_up();
  void lay_down();
  void wake();

  const std::function<void()> wake_;
  const Clock::duration grace_;
  std::atomic<bool> asked_{false};
  std::atomic<Clock::time_point> due_{};  // when carriers pass it on
  std::atomic<int> carriers_{0};
  std::atomic<bool> core_wanted_{false};  // nobody has lent it yet

  std::mutex mutex_;
  std::condition_variable work_ended_;
  bool working_ = false;  // under the mutex
};

}  // namespace alabaster
