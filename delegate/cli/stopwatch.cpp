#include "delegate/cli/stopwatch.h"

#include <sys/resource.h>
#include <time.h>

namespace alabaster::cli {
namespace {

double clock_seconds(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return double(now.tv_sec) + double(now.tv_nsec) * 1e-9;
}

}  // namespace

Stopwatch::Stopwatch()
    : wall_start_(clock_seconds(CLOCK_MONOTONIC)), cpu_start_(clock_seconds(CLOCK_PROCESS_CPUTIME_ID)) {}

double Stopwatch::wall() const {
  return clock_seconds(CLOCK_MONOTONIC) - wall_start_;
}
double Stopwatch::cpu() const {
  return clock_seconds(CLOCK_PROCESS_CPUTIME_ID) - cpu_start_;
}

double process_cpu_seconds() {
  return clock_seconds(CLOCK_PROCESS_CPUTIME_ID);
}

uint64_t peak_memory_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<uint64_t>(usage.ru_maxrss) * 1024;  // Linux counts kibibytes
}

}  // namespace alabaster::cli
