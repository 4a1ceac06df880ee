// Wall and CPU time of a phase.
#pragma once

#include <chrono>

#include "delegate/support/process_usage.h"

namespace alabaster::cli {

class Stopwatch {
 public:
  /// Seconds since construction, and CPU seconds of all threads since then.
  double wall() const { return std::chrono::duration<double>(Clock::now() - wall_start_).count(); }
  double cpu() const { return hd::support::process_cpu_seconds() - cpu_start_; }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point wall_start_ = Clock::now();
  double cpu_start_ = hd::support::process_cpu_seconds();
};

}  // namespace alabaster::cli
