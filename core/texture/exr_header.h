// EXR files whose header claims more than the file holds. Internal to this room.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/images/image_file.h"

namespace alabaster {

/// A file of `size` bytes: read(offset, bytes, count) within it; false if that fails.
struct FileBytes {
  uint64_t size = 0;
  std::function<bool(uint64_t offset, void* bytes, size_t count)> read;
};

/// One of a file's images.
struct ExrPart {
  struct Channel {
    std::string name;
    uint32_t type = 0;               // kExrHalf, or another of four bytes
    int32_t x_step = 1, y_step = 1;  // one sample for each of these pixels
  };
  std::string name;
  size_t number = 0;  // of the part
  bool is_multipart = false, is_tiled = false, is_deep = false;
  bool is_known = true;              // of a type that OpenEXR 3.1 knows
  std::array<int32_t, 4> window{};   // least x, least y, greatest x, greatest y
  std::array<int32_t, 4> display{};  // window of the picture
  uint32_t tile_width = 0, tile_height = 0;
  uint8_t tile_mode = 0;  // 1: also at halves of the size; 2: of each side; + 16: rounded up
  uint8_t compression = 0;
  uint32_t lines = 1;  // of a piece that is no tile
  std::vector<Channel> channels;
  uint32_t chunk_count = 0;  // as the file counts them
  uint64_t offsets = 0;      // where the table of its pieces begins
  enum class Environment { none, lat_long, cube } environment = Environment::none;  // a cube: six faces in a column
  std::optional<std::array<float, 8>> chromaticities;

  /// Their number, at all sizes.
  uint64_t pieces() const;
};
inline constexpr uint32_t kExrHalf = 1;

/// False, with the reason, where OpenEXR would set memory aside that neither the file's size nor its pixels justify: it
/// believes lengths and numbers of chunks before it reads them, and 600 bytes of file took 2 GB. All else that is wrong
/// with a header is left to it. Source: "OpenEXR File Layout", openexr.com.
/// `parts`, if any, gets what the header says of each image.
bool check_exr_header(const FileBytes& file, size_t max_pixels, ImageFault* fault,
                      std::vector<ExrPart>* parts = nullptr);

}  // namespace alabaster
