// Files that are there whole or not at all.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "delegate/api/types.h"

namespace alabaster::hd::host {

/// Whether the bytes must be on the disk before the call returns, so that they outlive a loss of power.
enum class Flush { disk, none };

/// Writes `bytes` to a temporary name in the folder of `file`, and renames. Empty on success, else the reason; then
/// `file` is what it was before and the temporary name is gone. Any thread.
ALABASTER_API std::string WriteFileAtomically(const std::string& file, std::span<const uint8_t> bytes,
                                              Flush flush = Flush::disk);

}  // namespace alabaster::hd::host
