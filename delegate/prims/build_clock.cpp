#include "delegate/prims/build_clock.h"

#include "delegate/support/process_usage.h"

namespace alabaster::hd::prims {

BuildClock::Seconds BuildClock::seconds(BuildPhase phase) const {
  const std::lock_guard lock(mutex_);
  return seconds_[static_cast<size_t>(phase)];
}

void BuildClock::change(BuildPhase phase, int by) {
  const std::lock_guard lock(mutex_);
  const auto wall = std::chrono::steady_clock::now();
  const double cpu = support::process_cpu_seconds();
  if (const int all = running_[0] + running_[1]; all > 0) {
    const double elapsed = std::chrono::duration<double>(wall - wall_).count();
    for (size_t i = 0; i < seconds_.size(); ++i) {
      if (running_[i] == 0) continue;
      seconds_[i].wall += elapsed;
      seconds_[i].cpu += (cpu - cpu_) * running_[i] / all;
    }
  }
  wall_ = wall;
  cpu_ = cpu;
  running_[static_cast<size_t>(phase)] += by;
}

}  // namespace alabaster::hd::prims
