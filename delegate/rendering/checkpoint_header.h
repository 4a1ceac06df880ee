// The header of a checkpoint file, read without trust. Internal to this room.
#pragma once

#include <string_view>

#include "delegate/rendering/checkpoint_file.h"

namespace alabaster::hd::rendering {

/// A longer header is refused: a scene has some hundred bytes for each of its prims.
inline constexpr size_t kMostHeaderBytes = size_t(64) << 20;

/// Reads what checkpoint_header() makes, and the members that a render may differ in, and nothing else: no deeper, no
/// longer, of no other type. `held` then holds the header in addition (MemoryRefused). Empty, or the reason.
std::string parse_checkpoint_header(std::string_view text, MemoryReservation* held, CheckpointHeader* header);

}  // namespace alabaster::hd::rendering
