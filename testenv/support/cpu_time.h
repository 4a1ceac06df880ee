// CPU time, which does not count the machine's other work.
#pragma once

#include <ctime>

namespace alabaster::testing {

/// CPU seconds of all threads of this process so far.
inline double cpu_seconds() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

}  // namespace alabaster::testing
