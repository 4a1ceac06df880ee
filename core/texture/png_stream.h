// PNG files made safe for libpng. Internal to this room.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace alabaster {

/// Copies a PNG file with nothing in it but the chunks that make the pixels, having checked every chunk's length and
/// CRC. libpng writes warnings to stderr (about a damaged chunk, a known-bad colour profile), and a library must not
/// print. The dropped chunks are not needed here: colour spaces are named by the scene.
/// Empty, with the reason in `error`, if the file is damaged.
std::vector<uint8_t> essential_png(std::span<const uint8_t> file, std::string& error);

}  // namespace alabaster
