#include "delegate/support/process_usage.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <ctime>
#include <fstream>
#include <limits>
#include <string>

namespace alabaster::hd::support {
namespace {

/// The lowest limit on the way to the process's group (cgroups, version 2, or the memory controller of version 1), as
/// far as it is mounted where systems mount it.
uint64_t cgroup_limit() {
  uint64_t lowest = std::numeric_limits<uint64_t>::max();
  const auto read = [&](const std::string& name) {
    uint64_t bytes = 0;
    if (std::ifstream(name) >> bytes && bytes > 0) lowest = std::min(lowest, bytes);  // "max" is no number
  };
  std::ifstream groups("/proc/self/cgroup");
  for (std::string line; std::getline(groups, line);) {
    const bool second = line.starts_with("0::");
    if (!second && line.find(":memory:") == std::string::npos) continue;
    const std::string root = second ? "/sys/fs/cgroup" : "/sys/fs/cgroup/memory";
    const std::string file = second ? "/memory.max" : "/memory.limit_in_bytes";
    for (std::string group = line.substr(line.rfind(':') + 1); !group.empty(); group.resize(group.rfind('/')))
      read(root + group + file);
    read(root + file);
  }
  return lowest;
}

}  // namespace

double process_cpu_seconds() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

uint64_t resident_memory_bytes() {
  std::ifstream file("/proc/self/statm");
  uint64_t total = 0, resident = 0;
  file >> total >> resident;
  return file ? resident * static_cast<uint64_t>(sysconf(_SC_PAGESIZE)) : 0;
}

uint64_t peak_memory_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<uint64_t>(usage.ru_maxrss) * 1024;  // Linux counts kibibytes
}

uint64_t usable_memory_bytes() {
  const long pages = sysconf(_SC_PHYS_PAGES), size = sysconf(_SC_PAGESIZE);
  if (pages <= 0 || size <= 0) return 0;
  const uint64_t physical = static_cast<uint64_t>(pages) * static_cast<uint64_t>(size);
  rlimit space{};
  const bool limited = getrlimit(RLIMIT_AS, &space) == 0 && space.rlim_cur != RLIM_INFINITY;
  return std::min({physical, cgroup_limit(), limited ? uint64_t(space.rlim_cur) : physical});
}

size_t default_memory_limit() {
  const uint64_t usable = usable_memory_bytes();
  return usable == 0 ? ~size_t(0) : static_cast<size_t>(usable / 4 * 3);
}

}  // namespace alabaster::hd::support
