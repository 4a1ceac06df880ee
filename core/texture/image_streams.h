// Copies of image files with nothing in them but what makes the pixels, checked before OpenImageIO sees them: 2.4 and
// 2.5 read and write beyond buffers where palettes, headers or metadata are damaged, and libpng prints. The dropped
// parts are not needed here, but for Exif's orientation: colour spaces are named by the scene. Internal to this room.
//
// Each function returns nothing, with the reason in `error`, if the file is damaged or of a kind that is not read.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace alabaster {

/// Checks every chunk's length and CRC. `orientation`: see exif_orientation().
std::vector<uint8_t> essential_png(std::span<const uint8_t> file, std::string& error, int* orientation = nullptr);

struct JpegFrame {
  uint32_t width = 0, height = 0, components = 0;
  int orientation = 1;
  size_t decoder_bytes = 0;  // that libjpeg takes for a frame that is coded in several scans
};
/// Drops what applications add (Exif, XMP, IPTC, profiles, comments).
std::vector<uint8_t> essential_jpeg(std::span<const uint8_t> file, JpegFrame& frame, std::string& error);

/// The still image, or the first frame of an animation.
std::vector<uint8_t> essential_webp(std::span<const uint8_t> file, std::string& error, int* orientation = nullptr);

/// Every index must be one of the palette's. Drops the footer of TGA 2.0, and what precedes a palette's first index.
std::vector<uint8_t> essential_tga(std::span<const uint8_t> file, std::string& error);

/// The first directory, with the entries that describe the pixels and a plausible number of rows a strip.
std::vector<uint8_t> essential_tiff(std::span<const uint8_t> file, std::string& error);

/// Where an image's first row and column lie, 1 to 8 as TIFF numbers it, by a block of Exif, with its signature before
/// it or without; 1 where it does not say.
int exif_orientation(std::span<const uint8_t> exif);

}  // namespace alabaster
