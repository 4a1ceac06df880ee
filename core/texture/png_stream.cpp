#include <array>
#include <cstring>
#include <string_view>

#include "core/texture/image_streams.h"

namespace alabaster {
namespace {

// CRC-32 of ISO 3309, as the PNG specification, annex D, gives it.
constexpr std::array<uint32_t, 256> kCrcTable = [] {
  std::array<uint32_t, 256> table{};
  for (uint32_t n = 0; n < 256; ++n) {
    uint32_t c = n;
    for (int bit = 0; bit < 8; ++bit) c = (c & 1) ? 0xedb88320u ^ (c >> 1) : c >> 1;
    table[n] = c;
  }
  return table;
}();

uint32_t crc32(std::span<const uint8_t> bytes) {
  uint32_t c = 0xffffffffu;
  for (const uint8_t byte : bytes) c = kCrcTable[(c ^ byte) & 0xff] ^ (c >> 8);
  return c ^ 0xffffffffu;
}

uint32_t big_endian(std::span<const uint8_t> bytes) {
  return uint32_t(bytes[0]) << 24 | uint32_t(bytes[1]) << 16 | uint32_t(bytes[2]) << 8 | uint32_t(bytes[3]);
}

}  // namespace

std::vector<uint8_t> essential_png(std::span<const uint8_t> file, std::string& error, int* orientation) {
  constexpr size_t kSignature = 8, kFrame = 12, kData = 8;  // a chunk's length, type and CRC
  std::vector<uint8_t> result;
  result.reserve(file.size());
  if (file.size() < kSignature) {
    error = "the file ends before its first chunk";
    return {};
  }
  result.assign(file.begin(), file.begin() + kSignature);
  bool has_exif = false;  // a file has one eXIf chunk; the first counts, as in libpng
  for (size_t at = kSignature;;) {
    if (file.size() - at < kFrame) {
      error = "the file is cut off (no IEND chunk)";
      return {};
    }
    const size_t length = big_endian(file.subspan(at));
    if (length > file.size() - at - kFrame) {
      error = "the file is cut off inside a chunk";
      return {};
    }
    const auto chunk = file.subspan(at, length + kFrame);
    const std::string_view type(reinterpret_cast<const char*>(chunk.data()) + 4, 4);
    if (crc32(chunk.subspan(4, length + 4)) != big_endian(chunk.subspan(length + 8))) {
      error = "a chunk's checksum is wrong";
      return {};
    }
    const bool critical = (chunk[4] & 0x20) == 0;  // PNG specification 5.4: upper-case first letter
    if (critical || type == "tRNS") result.insert(result.end(), chunk.begin(), chunk.end());
    if (type == "eXIf" && orientation && !has_exif) *orientation = exif_orientation(chunk.subspan(kData, length));
    has_exif |= type == "eXIf";
    if (type == "IEND") return result;
    at += chunk.size();
  }
}

}  // namespace alabaster
