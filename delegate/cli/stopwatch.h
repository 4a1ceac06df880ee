// Wall and CPU time of a phase.
#pragma once

#include <chrono>

namespace alabaster::cli {

class Stopwatch {
 public:
  Stopwatch();
  double wall() const;  // seconds since construction
  double cpu() const;   // CPU seconds of all threads since construction

 private:
  std::chrono::steady_clock::time_point wall_start_;
  double cpu_start_;
};

}  // namespace alabaster::cli
