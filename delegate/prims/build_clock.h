// Measures the time in which meshes are refined and their BVHs built, on many threads at once. The statistics name it
// sync.refineSeconds and sync.bvhSeconds.
#pragma once

#include <array>
#include <chrono>
#include <mutex>

namespace alabaster::hd::prims {

enum class BuildPhase { refine, bvh };

/// No thread's own clock can measure a phase: parallel loops inside it run on other threads, and its own thread takes
/// up work of another mesh while it waits. The clock is therefore read whenever a phase of any mesh begins or ends, and
/// the time since the last reading goes to the phases that were running.
class BuildClock {
 public:
  struct Seconds {
    double wall = 0;  // while this phase of at least one mesh was running; not a sum over meshes
    /// CPU time of the whole process meanwhile, a running render and the host included. Each interval is divided
    /// among the phases running, in proportion to the meshes in each.
    double cpu = 0;
  };
  Seconds seconds(BuildPhase phase) const;

  /// A phase of one mesh, which runs while this lives.
  class Running {
   public:
    Running(BuildClock* clock, BuildPhase phase) : clock_(clock), phase_(phase) { clock_->change(phase_, 1); }
    ~Running() { clock_->change(phase_, -1); }
    Running(const Running&) = delete;
    Running& operator=(const Running&) = delete;

   private:
    BuildClock* clock_;
    BuildPhase phase_;
  };

 private:
  void change(BuildPhase phase, int by);

  mutable std::mutex mutex_;
  std::array<Seconds, 2> seconds_;
  std::array<int, 2> running_{};
  std::chrono::steady_clock::time_point wall_;  // of the last change
  double cpu_ = 0;
};

}  // namespace alabaster::hd::prims
