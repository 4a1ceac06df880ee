#include "delegate/cli/stopwatch.h"

#include "delegate/support/process_usage.h"

namespace alabaster::cli {

Stopwatch::Stopwatch()
    : wall_start_(std::chrono::steady_clock::now()), cpu_start_(hd::support::process_cpu_seconds()) {}

double Stopwatch::wall() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - wall_start_).count();
}
double Stopwatch::cpu() const {
  return hd::support::process_cpu_seconds() - cpu_start_;
}

}  // namespace alabaster::cli
