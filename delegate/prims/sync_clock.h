// Where the time of Sync goes, when meshes are refined and their BVHs built by many threads that help each other.
#pragma once

#include <array>
#include <chrono>
#include <mutex>

namespace alabaster::hd::sync {

enum class SyncPhase { refine, bvh };

/// No thread's own clock can tell what a phase costs: parallel loops inside it run on other threads, and its own thread
/// takes up work of another mesh while it waits. So the clock is read whenever a phase of any mesh begins or ends, and
/// what has passed since is noted for the phases that were running.
class SyncClock {
 public:
  struct Seconds {
    double wall = 0;  // during which this phase of at least one mesh was running; not a sum over meshes
    /// Of the whole process while it was; each interval is shared among the phases running, in proportion to how many
    /// meshes were in each. A render that goes on meanwhile, and the host, are counted too.
    double cpu = 0;
  };
  Seconds seconds(SyncPhase phase) const;

  /// Runs a phase of one mesh for as long as it lives.
  class Running {
   public:
    Running(SyncClock* clock, SyncPhase phase) : clock_(clock), phase_(phase) { clock_->change(phase_, 1); }
    ~Running() { clock_->change(phase_, -1); }
    Running(const Running&) = delete;
    Running& operator=(const Running&) = delete;

   private:
    SyncClock* clock_;
    SyncPhase phase_;
  };

 private:
  void change(SyncPhase phase, int by);

  mutable std::mutex mutex_;
  std::array<Seconds, 2> seconds_;
  std::array<int, 2> running_{};
  std::chrono::steady_clock::time_point wall_;  // of the last change
  double cpu_ = 0;
};

}  // namespace alabaster::hd::sync
