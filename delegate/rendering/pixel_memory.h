// A picture of a buffer -> the caller's memory.
#pragma once

#include "delegate/api/prims.h"
#include "delegate/rendering/buffer_store.h"

namespace alabaster::hd::rendering {

/// Why pixels of `size` cannot be written there; empty if they can.
std::string memory_fault(const PixelMemory& memory, const Vec2i& size);

/// Writes what the memory does not show yet of a picture of its size, on the threads of the caller's TBB arena.
void show(const BufferStore& picture, PixelMemory* memory);

}  // namespace alabaster::hd::rendering
