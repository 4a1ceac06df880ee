// Files that are there whole or not at all.
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace alabaster::hd::host {

/// Writes `bytes` to a temporary name in the folder of `file`, flushes them to the disk and renames. Empty on success,
/// else the reason; then `file` is what it was before and the temporary name is gone.
std::string WriteFileAtomically(const std::string& file, std::span<const uint8_t> bytes);

}  // namespace alabaster::hd::host
