// Reading and writing by OpenImageIO. Internal to this room.
#pragma once

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include "core/images/image_file.h"

namespace alabaster {

/// Limits of the rows that are read at once: their bytes and their number.
inline constexpr size_t kMostRowBytes = size_t(64) << 20;
inline constexpr int kRowsAtOnce = 64;

/// OpenImageIO's text of a failure, or another one where that is empty: it is where threads are short.
inline std::string failure_text(const std::string& error) {
  if (!error.empty()) return error;
  return "OpenImageIO gives no reason; raise the limits of the process on threads, memory and files (ulimit -a)";
}

std::unique_ptr<ImageInput> open_image(const ImageSource& source, ImageFault& fault);
/// Decoded by libpng itself: OpenImageIO's reader lets it print its errors.
std::unique_ptr<ImageInput> open_png(const ImageSource& source, ImageFault& fault);
/// The image upright, where its rows begin elsewhere by Exif's `orientation`, 2 to 8.
std::unique_ptr<ImageInput> upright_image(std::unique_ptr<ImageInput> image, int orientation);
/// Empty, or why this process must not touch an EXR: OpenEXR would wait for threads that a forked process lacks.
std::string openexr_fault();
std::string encode_image(const ImageDescription& image, const RowSource& rows, std::vector<unsigned char>& file);
bool inflates_to(std::span<const uint8_t> stream, uint64_t size);

}  // namespace alabaster
