// ITU-T T.81, annex B.
#include <algorithm>

#include "core/texture/image_streams.h"

namespace alabaster {
namespace {

constexpr uint8_t kStart = 0xd8, kEnd = 0xd9, kScan = 0xda, kJfif = 0xe0, kExif = 0xe1, kAdobe = 0xee, kComment = 0xfe;

bool stands_alone(uint8_t marker) {
  return marker == 0x01 || (marker >= 0xd0 && marker <= 0xd7);
}
bool is_frame(uint8_t marker) {
  return marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
}
/// JFIF's and Adobe's segments say how the colours are coded.
bool is_essential(uint8_t marker) {
  return marker == kJfif || marker == kAdobe || (marker != kComment && (marker & 0xf0) != 0xe0);
}

/// The start of the first marker at or after `at`; entropy-coded data has none of its own.
size_t next_marker(std::span<const uint8_t> file, size_t at) {
  for (; at + 1 < file.size(); ++at)
    if (file[at] == 0xff && file[at + 1] != 0 && file[at + 1] != 0xff && !stands_alone(file[at + 1])) return at;
  return file.size();
}

void read_frame(std::span<const uint8_t> segment, JpegFrame& frame) {
  const auto number = [&](size_t at) { return uint32_t(segment[at]) << 8 | segment[at + 1]; };
  if (segment.size() < 10) return;
  frame.height = number(5), frame.width = number(7), frame.components = segment[9];
}

// The first block of Exif that turns the picture counts.
void read_exif(std::span<const uint8_t> segment, JpegFrame& frame) {
  constexpr size_t kHeader = 4;  // marker and length
  if (frame.orientation == 1) frame.orientation = exif_orientation(segment.subspan(kHeader));
}

constexpr size_t kCoefficient = 2;  // bytes

}  // namespace

std::vector<uint8_t> essential_jpeg(std::span<const uint8_t> file, JpegFrame& frame, std::string& error) {
  constexpr size_t kMostScans = 100;  // a progressive image has about ten
  const auto fail = [&](const char* reason) {
    error = reason;
    return std::vector<uint8_t>();
  };
  if (file.size() < 2 || file[1] != kStart) return fail("the file is cut off");
  std::vector<uint8_t> result;
  result.reserve(file.size());
  const auto copy = [&](size_t begin, size_t end) {
    const auto part = file.subspan(begin, end - begin);
    result.insert(result.end(), part.begin(), part.end());
  };
  copy(0, 2);
  bool has_frame = false, is_progressive = false;
  size_t scans = 0;
  for (size_t at = 2;;) {
    // libjpeg passes over filling and stray bytes, and so does this.
    while (at + 1 < file.size() && (file[at] != 0xff || file[at + 1] == 0 || file[at + 1] == 0xff)) ++at;
    if (at + 1 >= file.size()) return fail("the file is cut off");
    const uint8_t marker = file[at + 1];
    size_t end = at + 2;
    if (marker == kEnd) {
      copy(at, end);
      break;
    }
    if (!stands_alone(marker)) {
      if (file.size() - end < 2) return fail("the file is cut off");
      const size_t length = size_t(file[end]) << 8 | file[end + 1];
      if (length < 2 || length > file.size() - end) return fail("the file is cut off inside a segment");
      end += length;
    }
    if (is_frame(marker) && !has_frame) {
      has_frame = true;
      is_progressive = (marker & 0x03) == 2;
      read_frame(file.subspan(at, end - at), frame);
    }
    if (marker == kExif) read_exif(file.subspan(at, end - at), frame);
    if (marker == kScan) {
      if (++scans > kMostScans) return fail("it has more than 100 scans");
      end = next_marker(file, end);
    }
    if (is_essential(marker)) copy(at, end);
    at = end;
    if (marker == kScan && at == file.size()) break;  // libjpeg says whether all pixels are there
  }
  if (!has_frame || scans == 0) return fail("it holds no picture");
  if (is_progressive || scans > 1)
    frame.decoder_bytes = size_t(frame.width) * frame.height * frame.components * kCoefficient;
  return result;
}

}  // namespace alabaster
