#include "core/texture/exr_header.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

namespace alabaster {
namespace {

constexpr uint32_t kTiled = 0x200, kDeep = 0x800, kMultipart = 0x1000;
constexpr size_t kMostAttributes = size_t(1) << 16;
constexpr uint64_t kBlock = 4096;     // bytes
constexpr uint64_t kOffsetBytes = 8;  // a chunk's entry in the table of offsets

struct Attribute {
  std::string name, type;
  uint64_t begin = 0, size = 0;  // of the value
};

// The claims by which OpenEXR allocates.
struct Part {
  uint64_t width = 0, height = 0;
  uint64_t lines = 1;  // of a chunk
  uint64_t tile_width = 0, tile_height = 0;
  uint64_t chunks = 0;  // as the file counts them

  uint64_t least_chunks() const {
    const auto parts = [](uint64_t all, uint64_t one) { return (all + one - 1) / one; };
    if (tile_width > 0 && tile_height > 0)
      return std::max(chunks, parts(width, tile_width) * parts(height, tile_height));
    return std::max(chunks, parts(height, lines));
  }
};

class HeaderChecker {
 public:
  HeaderChecker(const FileBytes& file, size_t max_pixels, ImageFault* fault, std::vector<ExrPart>* parts)
      : file_(file), max_pixels_(max_pixels), fault_(*fault), parts_(parts) {}

  bool run() {
    uint32_t version = 0;
    if (!number(4, &version)) return true;  // too short for a header, which OpenEXR says
    at_ = 8;
    ExrPart first;
    first.is_multipart = (version & kMultipart) != 0;
    first.is_tiled = !first.is_multipart && (version & kTiled) != 0;
    first.is_deep = !first.is_multipart && (version & kDeep) != 0;
    std::vector<ExrPart> parts;
    bool empty = false;
    do {
      ExrPart part = first;
      part.number = parts.size();
      if (!check_part(&empty, &part)) return false;
      if (!empty || !first.is_multipart) parts.push_back(std::move(part));
    } while (first.is_multipart && !empty && at_ < file_.size);
    uint64_t offsets = at_;
    for (ExrPart& part : parts) {
      part.offsets = offsets;
      offsets += 8 * (part.is_known ? part.pieces() : part.chunk_count);
    }
    if (parts_) *parts_ = std::move(parts);
    return true;
  }

 private:
  bool fail(const char* code, const std::string& text) {
    fault_ = {code, text};
    return false;
  }
  bool cut_short(const std::string& claim) {
    return fail("texture.damaged", claim + ", more than the file has; export or copy the image again");
  }

  // By blocks, for names are read byte by byte.
  bool bytes(uint64_t offset, void* out, size_t count) {
    if (offset > file_.size || count > file_.size - offset) return false;
    if (offset < block_begin_ || offset + count > block_begin_ + block_.size()) {
      block_begin_ = offset;
      block_.resize(std::max(count, size_t(std::min(kBlock, file_.size - offset))));
      if (!file_.read(offset, block_.data(), block_.size())) return block_.clear(), false;
    }
    std::memcpy(out, block_.data() + (offset - block_begin_), count);
    return true;
  }

  // Little endian.
  bool number(uint64_t offset, uint32_t* value) {
    std::array<uint8_t, 4> bytes{};
    if (!this->bytes(offset, bytes.data(), bytes.size())) return false;
    *value = 0;
    for (size_t i = 4; i-- > 0;) *value = *value << 8 | bytes[i];
    return true;
  }

  // Names have at most 255 bytes. False: it is longer, or the file ends.
  bool word(std::string* text) {
    text->clear();
    for (char c = 0; text->size() < 256; text->push_back(c)) {
      if (!bytes(at_, &c, 1)) return false;
      ++at_;
      if (c == 0) return true;
    }
    return false;
  }

  bool check_part(bool* empty, ExrPart* filled) {
    Part part;
    *empty = true;
    Attribute attribute;
    uint32_t size = 0;
    while (word(&attribute.name) && !attribute.name.empty()) {
      *empty = false;
      if (++attributes_ > kMostAttributes)
        return fail("texture.size",
                    "the image has more than " + std::to_string(kMostAttributes) + " attributes; export it with fewer");
      if (!word(&attribute.type) || !number(at_, &size)) return true;  // OpenEXR finds the same
      at_ += 4;
      attribute.begin = at_;
      attribute.size = size;
      if (size > file_.size - std::min(file_.size, at_))
        return cut_short("its attribute '" + attribute.name + "' claims " + std::to_string(size) + " bytes");
      if (attribute.type == "stringvector" && !check_strings(attribute)) return false;
      read(attribute, &part);
      fill(attribute, filled);
      at_ = attribute.begin + size;
    }
    filled->lines = uint32_t(part.lines);
    return check_sizes(part);
  }

  // Each text has its length before it.
  bool check_strings(const Attribute& strings) {
    uint64_t at = strings.begin, end = strings.begin + strings.size;
    for (uint32_t length = 0; at + 4 <= end && number(at, &length); at += 4 + uint64_t(length))
      if (length > end - at - 4)
        return cut_short("a text of its attribute '" + strings.name + "' claims " + std::to_string(length) + " bytes");
    return true;
  }

  void read(const Attribute& attribute, Part* part) {
    const auto value = [&](uint64_t i) {
      uint32_t read = 0;
      number(attribute.begin + 4 * i, &read);
      return read;
    };
    if (attribute.name == "dataWindow" && attribute.size >= 16) {
      const auto extent = [&](uint64_t low) {
        const int64_t pixels = int64_t(int32_t(value(low + 2))) - int32_t(value(low)) + 1;
        return pixels > 0 ? uint64_t(pixels) : 0;
      };
      part->width = extent(0), part->height = extent(1);
    } else if (attribute.name == "tiles" && attribute.size >= 8) {
      part->tile_width = value(0), part->tile_height = value(1);
    } else if (attribute.name == "chunkCount" && attribute.size >= 4) {
      part->chunks = value(0);
    } else if (attribute.name == "compression" && attribute.size >= 1) {
      // none, RLE, ZIPS, ZIP, PIZ, PXR24, B44, B44A, DWAA, DWAB
      constexpr std::array<uint64_t, 10> kLines = {1, 1, 1, 16, 32, 16, 32, 32, 32, 256};
      uint8_t kind = 0;
      if (bytes(attribute.begin, &kind, 1) && kind < kLines.size()) part->lines = kLines[kind];
    }
  }

  void fill(const Attribute& attribute, ExrPart* part) {
    uint32_t number = 0;
    if ((attribute.name == "dataWindow" || attribute.name == "displayWindow") && attribute.size >= 16) {
      for (size_t i = 0; i < 4; ++i)
        (attribute.name == "dataWindow" ? part->window : part->display)[i] =
            this->number(attribute.begin + 4 * i, &number) ? int32_t(number) : 0;
    } else if (attribute.name == "tiles" && attribute.size >= 8) {
      this->number(attribute.begin, &part->tile_width);
      this->number(attribute.begin + 4, &part->tile_height);
      if (attribute.size >= 9) bytes(attribute.begin + 8, &part->tile_mode, 1);
    } else if (attribute.name == "compression" && attribute.size >= 1) {
      bytes(attribute.begin, &part->compression, 1);
    } else if (attribute.name == "type" && part->is_multipart) {
      const std::string type = text(attribute);
      part->is_tiled = type == "tiledimage" || type == "deeptile";
      part->is_deep = type.starts_with("deep");
      part->is_known = part->is_tiled || type == "scanlineimage" || type == "deepscanline";
    } else if (attribute.name == "name") {
      part->name = text(attribute);
    } else if (attribute.name == "chunkCount" && attribute.size >= 4) {
      this->number(attribute.begin, &part->chunk_count);
    } else if (attribute.name == "envmap" && attribute.size >= 1) {
      uint8_t kind = 0;
      if (bytes(attribute.begin, &kind, 1) && kind < 2)
        part->environment = kind == 1 ? ExrPart::Environment::cube : ExrPart::Environment::lat_long;
    } else if (attribute.name == "chromaticities" && attribute.size >= 32) {
      part->chromaticities.emplace();
      for (size_t i = 0; i < 8; ++i)
        (*part->chromaticities)[i] =
            this->number(attribute.begin + 4 * i, &number) ? std::bit_cast<float>(number) : 0.0f;
    } else if (attribute.name == "channels") {
      fill_channels(attribute, part);
    }
  }

  std::string text(const Attribute& attribute) {
    std::string text(size_t(std::min<uint64_t>(attribute.size, 255)), '\0');
    if (!bytes(attribute.begin, text.data(), text.size())) text.clear();
    return text;
  }

  void fill_channels(const Attribute& attribute, ExrPart* part) {
    const uint64_t end = attribute.begin + attribute.size;
    part->channels.clear();
    at_ = attribute.begin;
    ExrPart::Channel channel;
    uint32_t x_step = 0, y_step = 0;
    constexpr size_t kMostChannels = 4096;  // more are no picture's
    while (part->channels.size() < kMostChannels && at_ < end && word(&channel.name) && !channel.name.empty() &&
           number(at_, &channel.type) && number(at_ + 8, &x_step) && number(at_ + 12, &y_step)) {
      at_ += 16;
      channel.x_step = int32_t(x_step), channel.y_step = int32_t(y_step);
      part->channels.push_back(channel);
    }
  }

  bool check_sizes(const Part& part) {
    const auto by = [](uint64_t a, uint64_t b) { return std::to_string(a) + " x " + std::to_string(b); };
    // Sides are below 2^32, but the product of two may not be.
    const auto too_many = [](uint64_t a, uint64_t b, uint64_t most) { return a > 0 && b > most / a; };
    if (too_many(part.width, part.height, max_pixels_))
      return fail("texture.size", "the image claims " + by(part.width, part.height) + " pixels and the limit is " +
                                      std::to_string(max_pixels_) + " pixels; make it smaller");
    constexpr uint64_t kLargestTile = uint64_t(1) << 22;  // of an image that is smaller than its tile
    if (too_many(part.tile_width, part.tile_height, std::max(kLargestTile, part.width * part.height)))
      return fail("texture.size", "the image claims tiles of " + by(part.tile_width, part.tile_height) +
                                      " pixels, more than it has itself; write it with smaller tiles");
    chunks_ += part.least_chunks();
    if (chunks_ > file_.size / kOffsetBytes) return cut_short("it claims " + std::to_string(chunks_) + " pieces");
    return true;
  }

  const FileBytes& file_;
  const size_t max_pixels_;
  ImageFault& fault_;
  std::vector<ExrPart>* const parts_;
  uint64_t at_ = 0;
  size_t attributes_ = 0;  // of the parts so far
  uint64_t chunks_ = 0;    // of these
  std::vector<uint8_t> block_;
  uint64_t block_begin_ = 0;  // in the file
};

}  // namespace

// A side is halved until it has one pixel.
uint64_t ExrPart::pieces() const {
  const auto side = [this](size_t axis) {
    const int64_t pixels = int64_t(window[axis + 2]) - window[axis] + 1;
    return pixels > 0 ? uint64_t(pixels) : 0;
  };
  const auto parts_of = [](uint64_t all, uint64_t one) { return (all + one - 1) / one; };
  const uint64_t width = side(0), height = side(1);
  if (!is_tiled) return parts_of(height, std::max(lines, 1u));
  if (tile_width == 0 || tile_height == 0) return 0;
  const bool is_up = (tile_mode & 0x10) != 0;
  const auto levels_of = [is_up](uint64_t size) -> uint64_t {
    size = std::max<uint64_t>(size, 1);
    return uint64_t(is_up ? std::bit_width(size - 1) + 1 : std::bit_width(size));
  };
  const auto tiles_of = [&](uint64_t size, uint64_t tile, uint64_t level) {
    const uint64_t rounding = is_up ? (uint64_t(1) << level) - 1 : 0;
    return parts_of(std::max<uint64_t>((size + rounding) >> level, 1), tile);
  };
  const int mode = tile_mode & 0xf;
  const uint64_t levels = mode == 0 ? 1 : levels_of(std::max(width, height));
  uint64_t count = 0;
  if (mode < 2) {
    for (uint64_t i = 0; i < levels; ++i) count += tiles_of(width, tile_width, i) * tiles_of(height, tile_height, i);
    return count;
  }
  for (uint64_t i = 0; i < levels_of(width); ++i)
    for (uint64_t j = 0; j < levels_of(height); ++j)
      count += tiles_of(width, tile_width, i) * tiles_of(height, tile_height, j);
  return count;
}

bool check_exr_header(const FileBytes& file, size_t max_pixels, ImageFault* fault, std::vector<ExrPart>* parts) {
  return HeaderChecker(file, max_pixels, fault, parts).run();
}

}  // namespace alabaster
