// What this process has used so far.
#pragma once

#include <cstdint>

namespace alabaster::hd::support {

/// CPU seconds of all threads, user and system.
double process_cpu_seconds();
/// The most memory that was ever resident, in bytes.
int64_t peak_memory_bytes();
/// Of the machine, in bytes; 0 if it cannot be known.
uint64_t physical_memory_bytes();

}  // namespace alabaster::hd::support
