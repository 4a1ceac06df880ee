// Wall and CPU time of a phase, and the process's memory.
#pragma once

#include <cstdint>

namespace alabaster::cli {

class Stopwatch {
 public:
  Stopwatch();
  double wall() const;  // seconds since construction
  double cpu() const;   // CPU seconds of all threads since construction

 private:
  double wall_start_, cpu_start_;
};

/// CPU seconds of all threads since the process began.
double process_cpu_seconds();

uint64_t peak_memory_bytes();

}  // namespace alabaster::cli
