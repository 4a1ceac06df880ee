// CPU time and memory of this process, and memory of the machine, as the system reports them.
#pragma once

#include <cstdint>

namespace alabaster::hd::support {

/// CPU seconds of all threads, user and system.
double process_cpu_seconds();
/// Memory that is resident now, in bytes; 0 if the system does not say.
uint64_t resident_memory_bytes();
/// The most memory that was ever resident, in bytes.
uint64_t peak_memory_bytes();
/// Memory of the machine, in bytes; 0 if the system does not say.
uint64_t physical_memory_bytes();

}  // namespace alabaster::hd::support
