// Truevision TGA file format specification, version 2.0.
#include <algorithm>
#include <initializer_list>

#include "core/texture/image_streams.h"

namespace alabaster {
namespace {

constexpr size_t kHeader = 18, kFooter = 26;
constexpr uint8_t kPaletted = 1, kColor = 2, kGrey = 3, kRunLengths = 8;

uint32_t short_at(std::span<const uint8_t> bytes, size_t at) {
  return uint32_t(bytes[at]) | uint32_t(bytes[at + 1]) << 8;
}

struct Header {
  explicit Header(std::span<const uint8_t> file)
      : id(file[0]),
        kind(file[2] & ~kRunLengths),
        runs((file[2] & kRunLengths) != 0),
        has_palette(file[1] == 1),
        first(short_at(file, 3)),
        length(short_at(file, 5)),
        entry(file[7]),
        texels(size_t(short_at(file, 12)) * short_at(file, 14)),
        bits(file[16]) {}

  size_t texel_bytes() const { return (bits + 7u) / 8; }
  size_t entry_bytes() const { return (entry + 7u) / 8; }
  /// Empty, or why OpenImageIO is not to read it.
  std::string fault() const {
    const auto one_of = [](uint8_t value, std::initializer_list<int> list) {
      return std::find(list.begin(), list.end(), value) != list.end();
    };
    const bool fits = kind == kPaletted ? has_palette && one_of(bits, {8, 16}) && one_of(entry, {15, 16, 24, 32})
                      : kind == kColor  ? one_of(bits, {15, 16, 24, 32})
                                        : kind == kGrey && one_of(bits, {8, 16});
    if (!fits) return "its header describes no TGA of a kind that is read";
    if (kind == kPaletted && first + length > UINT16_MAX) return "its palette has more than 65535 entries";
    return {};
  }

  const uint8_t id, kind;
  const bool runs, has_palette;
  const uint32_t first, length;  // the palette holds the colours of these indices
  const uint8_t entry;           // bits
  const size_t texels;
  const uint8_t bits;
};

/// True if `count` texels have colours.
bool have_colors(std::span<const uint8_t> texels, size_t count, const Header& header) {
  if (header.kind != kPaletted) return true;
  const size_t bytes = header.texel_bytes();
  for (size_t i = 0; i < count; ++i) {
    const uint32_t index = bytes == 1 ? texels[i] : short_at(texels, 2 * i);
    if (index < header.first || index - header.first >= header.length) return false;
  }
  return true;
}

/// The bytes of all texels; 0 with the fault.
size_t checked_texels(std::span<const uint8_t> data, const Header& header, std::string& error) {
  const size_t bytes = header.texel_bytes();
  size_t at = 0;
  for (size_t left = header.texels; left > 0;) {
    size_t count = left, stored = left;
    if (header.runs) {
      if (at == data.size()) break;
      count = std::min(left, size_t(data[at] & 0x7f) + 1);
      stored = (data[at] & 0x80) != 0 ? 1 : count;
      ++at;
    }
    if (data.size() - at < stored * bytes) break;
    if (!have_colors(data.subspan(at), stored, header)) {
      error = "a texel's index is not in its palette";
      return 0;
    }
    at += stored * bytes;
    left -= count;
    if (left == 0) return at;
  }
  error = header.texels == 0 ? "the image has no pixels" : "the file is cut off";
  return 0;
}

void set_short(std::vector<uint8_t>& bytes, size_t at, size_t value) {
  bytes[at] = uint8_t(value), bytes[at + 1] = uint8_t(value >> 8);
}

}  // namespace

// OpenImageIO adds the palette's first index to a texel's, so the palette is given from index 0 on.
std::vector<uint8_t> essential_tga(std::span<const uint8_t> file, std::string& error) {
  if (file.size() < kHeader) {
    error = "the file is cut off";
    return {};
  }
  const Header header(file);
  if (error = header.fault(); !error.empty()) return {};
  const size_t palette = header.has_palette ? header.length * header.entry_bytes() : 0;
  const size_t palette_at = kHeader + header.id, texels_at = palette_at + palette;
  if (file.size() < texels_at) {
    error = "the file is cut off inside its palette";
    return {};
  }
  const size_t texels = checked_texels(file.subspan(texels_at), header, error);
  if (texels == 0) return {};

  const bool paletted = header.kind == kPaletted;
  const size_t before = paletted ? header.first * header.entry_bytes() : 0;
  std::vector<uint8_t> result;
  result.reserve(kHeader + before + palette + texels + kFooter);
  result.assign(file.begin(), file.begin() + kHeader);
  result[0] = 0;
  result[1] = paletted ? 1 : 0;
  set_short(result, 3, 0);
  set_short(result, 5, paletted ? header.first + header.length : 0);
  result.resize(kHeader + before, 0);
  const auto copy = [&](size_t at, size_t count) {
    const auto part = file.subspan(at, count);
    result.insert(result.end(), part.begin(), part.end());
  };
  if (paletted) copy(palette_at, palette);
  copy(texels_at, texels);
  result.resize(result.size() + kFooter, 0);  // no texels look like the footer of TGA 2.0
  return result;
}

}  // namespace alabaster
