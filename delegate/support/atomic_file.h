// Files that are there whole or not at all.
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace alabaster::hd::support {

/// disk: the call returns when the bytes are on the disk, where they outlive a loss of power.
enum class Flush { disk, none };

/// Writes `bytes` to a temporary file in the folder of `file` and renames it. Returns nothing on success, else the
/// reason; then `file` is as it was before and the temporary file is gone. Any thread.
std::string WriteFileAtomically(const std::string& file, std::span<const uint8_t> bytes, Flush flush = Flush::disk);

}  // namespace alabaster::hd::support
