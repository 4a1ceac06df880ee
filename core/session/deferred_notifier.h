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
/// edit_latency). A host's thread therefore calls request(), which sets a flag. Render threads poll the flag before
/// each sample, and one of them notifies. While no thread polls, cores are free, and request() notifies.
class DeferredNotifier {
 public:
  using Clock = std::chrono::steady_clock;
  /// `notify` is called on any thread, on several at once, and must not throw. A poller delays it by `grace`: the
  /// thread that wakes up may take the core of the one that requested it, which should be done by then.
  explicit DeferredNotifier(std::function<void()> notify, Clock::duration grace)
      : notify_(std::move(notify)), grace_(grace) {}

  void request();

  /// The notified thread works between these two calls, which it makes itself.
  void begin_work();
  void end_work();
  bool wants_core() const { return core_wanted_.load(std::memory_order_relaxed); }
  /// Called by a render thread where there are no more cores than render threads. The first call since begin_work()
  /// returns once the work has ended, `stopped` is true, or 30 ms have passed. Other calls return at once.
  void yield_core(const std::atomic<bool>& stopped);

  /// While it lives, its thread calls poll() again and again. The notifier may be null: poll() then does nothing.
  class Poller {
   public:
    explicit Poller(DeferredNotifier* notifier) : notifier_(notifier) {
      if (notifier_) notifier_->add_poller();
    }
    ~Poller() {
      if (notifier_) notifier_->remove_poller();
    }
    Poller(const Poller&) = delete;
    Poller& operator=(const Poller&) = delete;
    void poll() const {
      if (notifier_) notifier_->poll();
    }

   private:
    DeferredNotifier* const notifier_;
  };

  /// While it lives, its thread, which has a Poller, waits and does not poll.
  class PollingPause {
   public:
    explicit PollingPause(DeferredNotifier* notifier) : notifier_(notifier) {
      if (notifier_) notifier_->remove_poller();
    }
    ~PollingPause() {
      if (notifier_) notifier_->add_poller();
    }
    PollingPause(const PollingPause&) = delete;
    PollingPause& operator=(const PollingPause&) = delete;

   private:
    DeferredNotifier* const notifier_;
  };

 private:
  void poll() {
    if (requested_ && Clock::now() >= due_.load()) notify();
  }
  void add_poller();
  void remove_poller();
  void notify();

  const std::function<void()> notify_;
  const Clock::duration grace_;
  std::atomic<bool> requested_{false};
  std::atomic<Clock::time_point> due_{};  // pollers notify from then on
  std::atomic<int> pollers_{0};
  std::atomic<bool> core_wanted_{false};  // by the work, and no thread has yielded its core to it yet

  std::mutex mutex_;
  std::condition_variable work_ended_;
  bool working_ = false;  // under the mutex
};

}  // namespace alabaster
