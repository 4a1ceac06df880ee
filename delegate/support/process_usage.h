// CPU time and memory of this process, and memory of the machine, as the system reports them.
#pragma once

#include <cstddef>
#include <cstdint>

namespace alabaster::hd::support {

/// CPU seconds of all threads, user and system.
double process_cpu_seconds();
/// Memory that is resident now, in bytes; 0 if the system does not say.
uint64_t resident_memory_bytes();
/// The most memory that was ever resident, in bytes.
uint64_t peak_memory_bytes();
/// Memory that this process may use, in bytes: the machine's, or the limit of its cgroup or of its address space if
/// that is lower. 0 if the system does not say.
uint64_t usable_memory_bytes();
/// Three quarters of that. The rest is for what no budget counts: libraries, what malloc keeps, the system.
size_t default_memory_limit();

}  // namespace alabaster::hd::support
