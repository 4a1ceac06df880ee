// WebP container specification (RFC 9649, section 2).
#include <algorithm>
#include <string_view>

#include "core/texture/image_streams.h"

namespace alabaster {
namespace {

using Bytes = std::span<const uint8_t>;

uint32_t number(Bytes bytes, size_t at, size_t count) {
  uint32_t value = 0;
  for (size_t i = count; i-- > 0;) value = value << 8 | bytes[at + i];
  return value;
}

/// A chunk of a RIFF file: its whole, and what it holds.
struct Chunk {
  std::string_view type;
  Bytes whole, payload;
};

/// Goes through the chunks one after the other.
class Chunks {
 public:
  explicit Chunks(Bytes bytes) : left_(bytes) {}
  /// False at the end, and if the next chunk is cut off.
  bool next(Chunk& chunk) {
    constexpr size_t kFrame = 8;
    if (left_.size() < kFrame) return is_cut_ = !left_.empty(), false;
    const size_t size = number(left_, 4, 4);
    if (size > left_.size() - kFrame) return is_cut_ = true, false;
    chunk = {{reinterpret_cast<const char*>(left_.data()), 4}, left_.first(kFrame + size), left_.subspan(kFrame, size)};
    left_ = left_.subspan(std::min(left_.size(), kFrame + size + size % 2));
    return true;
  }
  bool is_cut() const { return is_cut_; }

 private:
  Bytes left_;
  bool is_cut_ = false;
};

bool is_picture(const Chunk& chunk) {
  return chunk.type == "VP8 " || chunk.type == "VP8L";
}

/// A file of these chunks.
class Writer {
 public:
  void add(Bytes chunk) {
    bytes_.insert(bytes_.end(), chunk.begin(), chunk.end());
    if (bytes_.size() % 2 != 0) bytes_.push_back(0);
  }
  std::vector<uint8_t> take() {
    const auto size = uint32_t(bytes_.size() - 8);
    for (size_t i = 0; i < 4; ++i) bytes_[4 + i] = uint8_t(size >> (8 * i));
    return std::move(bytes_);
  }

 private:
  std::vector<uint8_t> bytes_{'R', 'I', 'F', 'F', 0, 0, 0, 0, 'W', 'E', 'B', 'P'};
};

/// The header of an extended file.
struct Extended {
  static constexpr size_t kSize = 10, kFlags = 8;  // kFlags: in the whole chunk
  static constexpr uint8_t kAnimation = 0x02, kAlpha = 0x10;
  std::vector<uint8_t> header;  // the whole chunk
  bool is_animation() const { return (header[kFlags] & kAnimation) != 0; }
  Bytes canvas() const { return Bytes(header).subspan(kFlags + 4, 6); }  // width - 1 and height - 1 of 24 bits each
};

/// The chunks that make the first frame of an animation; empty with the fault.
Bytes first_frame(Bytes chunks, const Extended& extended, std::string& error) {
  constexpr size_t kPlace = 6, kSize = 6, kHeader = 16;  // of a frame: its place, its size, and all before its chunks
  Chunks all(chunks);
  for (Chunk chunk; all.next(chunk);) {
    if (chunk.type != "ANMF" || chunk.payload.size() < kHeader) continue;
    const Bytes place = chunk.payload.first(kPlace), size = chunk.payload.subspan(kPlace, kSize);
    // OpenImageIO leaves the rest of the picture as its memory was.
    if (std::any_of(place.begin(), place.end(), [](uint8_t byte) { return byte != 0; }) ||
        !std::equal(size.begin(), size.end(), extended.canvas().begin())) {
      error = "the first frame of its animation does not cover the picture";
      return {};
    }
    return chunk.payload.subspan(kHeader);
  }
  error = all.is_cut() ? "the file is cut off inside a chunk" : "it is an animation without frames";
  return {};
}

/// Exif's, which follows the picture.
int orientation_of(Bytes chunks) {
  Chunks all(chunks);
  for (Chunk chunk; all.next(chunk);)
    if (chunk.type == "EXIF") return exif_orientation(chunk.payload);
  return 1;
}

}  // namespace

std::vector<uint8_t> essential_webp(std::span<const uint8_t> file, std::string& error, int* orientation) {
  constexpr size_t kHeader = 12;
  Bytes body = file.subspan(std::min(file.size(), kHeader));
  if (orientation) *orientation = orientation_of(body);
  Writer writer;
  Chunk chunk;
  Chunks chunks(body);
  bool any = chunks.next(chunk);
  if (any && chunk.type == "VP8X" && chunk.payload.size() >= Extended::kSize) {
    Extended extended{{chunk.whole.begin(), chunk.whole.end()}};
    body = body.subspan(std::min(body.size(), chunk.whole.size() + chunk.whole.size() % 2));
    if (extended.is_animation() && (body = first_frame(body, extended, error)).empty()) return {};
    extended.header[Extended::kFlags] &= Extended::kAlpha;
    writer.add(extended.header);
    chunks = Chunks(body);
    any = chunks.next(chunk);
  }
  for (; any; any = chunks.next(chunk)) {
    if (chunk.type == "ALPH" || is_picture(chunk)) writer.add(chunk.whole);
    if (is_picture(chunk)) return writer.take();
  }
  error = chunks.is_cut() ? "the file is cut off inside a chunk" : "it holds no picture";
  return {};
}

}  // namespace alabaster
