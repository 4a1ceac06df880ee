// EXR files whose header claims more than the file holds. Internal to this room.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>

#include "core/images/image_file.h"

namespace alabaster {

/// A file of `size` bytes: read(offset, bytes, count) within it; false if that fails.
struct FileBytes {
  uint64_t size = 0;
  std::function<bool(uint64_t offset, void* bytes, size_t count)> read;
};

/// False, with the reason, where OpenEXR would set memory aside that neither the file's size nor its pixels justify: it
/// believes lengths and numbers of chunks before it reads them, and 600 bytes of file took 2 GB. All else that is wrong
/// with a header is left to it. Source: "OpenEXR File Layout", openexr.com.
bool check_exr_header(const FileBytes& file, size_t max_pixels, ImageFault* fault);

}  // namespace alabaster
