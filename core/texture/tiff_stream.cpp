// TIFF, revision 6.0, and Adobe's supplements.
#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <string_view>

#include "core/texture/image_streams.h"

namespace alabaster {
namespace {

using Bytes = std::span<const uint8_t>;

enum Tag : uint16_t {
  kWidth = 256,
  kHeight = 257,
  kBits = 258,
  kCompression = 259,
  kPhotometric = 262,
  kFillOrder = 266,
  kStripOffsets = 273,
  kOrientation = 274,
  kSamples = 277,
  kRowsPerStrip = 278,
  kStripBytes = 279,
  kPlanes = 284,
  kFaxOptions3 = 292,
  kFaxOptions4 = 293,
  kPredictor = 317,
  kColorMap = 320,
  kTileWidth = 322,
  kTileHeight = 323,
  kTileOffsets = 324,
  kTileBytes = 325,
  kInkSet = 332,
  kExtraSamples = 338,
  kSampleFormat = 339,
  kJpegTables = 347,
  kYCbCrWeights = 529,
  kYCbCrSubsampling = 530,
  kYCbCrPositions = 531,
  kReferenceBlackWhite = 532,
  kDepth = 32997,
  kTileDepth = 32998,
};
constexpr std::array kKept = {kWidth,        kHeight,           kBits,           kCompression,
                              kPhotometric,  kFillOrder,        kStripOffsets,   kOrientation,
                              kSamples,      kRowsPerStrip,     kStripBytes,     kPlanes,
                              kFaxOptions3,  kFaxOptions4,      kPredictor,      kColorMap,
                              kTileWidth,    kTileHeight,       kTileOffsets,    kTileBytes,
                              kInkSet,       kExtraSamples,     kSampleFormat,   kJpegTables,
                              kYCbCrWeights, kYCbCrSubsampling, kYCbCrPositions, kReferenceBlackWhite,
                              kDepth,        kTileDepth};
enum : uint32_t { kWhiteIsZero = 0, kBlackIsZero = 1, kRgb = 2, kPalette = 3, kSeparated = 5, kYCbCr = 6, kCieLab = 8 };
enum : uint32_t { kUnsigned = 1, kSigned = 2, kFloat = 3, kUntyped = 4 };
enum : uint32_t { kOldJpeg = 6, kJpeg = 7 };
enum Type : uint16_t { kByte = 1, kShort = 3, kLong = 4 };

constexpr size_t kEntry = 12, kInline = 4;

/// The first directory of a file.
class Directory {
 public:
  explicit Directory(Bytes file) : file_(file), is_big_endian_(file[0] == 'M') {}

  /// False if it is cut off.
  bool read() {
    const size_t at = number(4, 4);
    if (at > file_.size() || file_.size() - at < 2) return false;
    const size_t count = number(at, 2);
    if (file_.size() - at - 2 < count * kEntry) return false;
    for (size_t i = 0; i < count; ++i) {
      const size_t entry = at + 2 + i * kEntry;
      const auto tag = uint16_t(number(entry, 2));
      if (std::find(kKept.begin(), kKept.end(), tag) != kKept.end())
        entries_.try_emplace(tag, file_.subspan(entry, kEntry));
    }
    return true;
  }
  bool has(Tag tag) const { return entries_.contains(tag); }
  size_t count(Tag tag) const { return has(tag) ? entry_number(tag, 4, 4) : 0; }
  /// None if it is not there, or no whole number, or cut off.
  std::optional<uint32_t> value(Tag tag, size_t index = 0) const {
    if (index >= count(tag)) return std::nullopt;
    const size_t type = entry_number(tag, 2, 2), size = type == kByte ? 1 : type == kShort ? 2 : type == kLong ? 4 : 0;
    if (size == 0) return std::nullopt;
    const auto entry = size_t(entries_.at(tag).data() - file_.data());
    const size_t at = (count(tag) * size <= kInline ? entry + 8 : entry_number(tag, 8, 4)) + index * size;
    if (at > file_.size() || file_.size() - at < size) return std::nullopt;
    return number(at, size);
  }
  uint32_t value_or(Tag tag, uint32_t standard) const { return has(tag) ? value(tag).value_or(UINT32_MAX) : standard; }
  /// True if all of the tag's values are that.
  bool are_all(Tag tag, uint32_t wanted) const {
    for (size_t i = 0; i < count(tag); ++i)
      if (value(tag, i) != wanted) return false;
    return true;
  }

  void remove(Tag tag) { entries_.erase(tag); }

  /// The file with this directory at its end, and no other. `numbers` replace what it says.
  std::vector<uint8_t> file_with(const std::map<uint16_t, uint32_t>& numbers) const {
    std::vector<uint8_t> result;
    result.reserve(file_.size() + 8 + (entries_.size() + numbers.size()) * kEntry);
    result.assign(file_.begin(), file_.end());
    if (result.size() % 2 != 0) result.push_back(0);
    for (size_t i = 0; i < 4; ++i) result[4 + i] = digit(uint32_t(result.size()), i, 4);
    const auto add = [&](uint32_t value, size_t size) {
      for (size_t i = 0; i < size; ++i) result.push_back(digit(value, i, size));
    };
    auto entries = entries_;
    for (const auto& [tag, value] : numbers) entries[tag] = {};
    add(uint32_t(entries.size()), 2);
    for (const auto& [tag, entry] : entries)
      if (const auto replaced = numbers.find(tag); replaced != numbers.end())
        add(tag, 2), add(kLong, 2), add(1, 4), add(replaced->second, 4);
      else
        result.insert(result.end(), entry.begin(), entry.end());
    add(0, 4);
    return result;
  }

 private:
  uint32_t number(size_t at, size_t size) const {
    uint32_t value = 0;
    for (size_t i = 0; i < size; ++i) value = value << 8 | file_[at + (is_big_endian_ ? i : size - 1 - i)];
    return value;
  }
  uint32_t entry_number(Tag tag, size_t at, size_t size) const {
    return number(size_t(entries_.at(tag).data() - file_.data()) + at, size);
  }
  uint8_t digit(uint32_t value, size_t i, size_t size) const {
    return uint8_t(value >> (8 * (is_big_endian_ ? size - 1 - i : i)));
  }

  const Bytes file_;
  const bool is_big_endian_;
  std::map<uint16_t, Bytes> entries_;
};

/// The pixels, as the directory describes them.
struct Pixels {
  explicit Pixels(const Directory& d)
      : width(d.value_or(kWidth, 0)),
        height(d.value_or(kHeight, 0)),
        samples(d.value_or(kSamples, 1)),
        bits(d.value_or(kBits, 1)),
        stored_format(d.value_or(kSampleFormat, kUnsigned)),
        format(stored_format == kUntyped ? kUnsigned : stored_format),  // as revision 6.0 says of both
        photometric(d.value_or(kPhotometric, samples == 1 ? kBlackIsZero : kRgb)),
        compression(d.value_or(kCompression, 1)),
        tile_width(d.value_or(kTileWidth, 0)),
        tile_height(d.value_or(kTileHeight, 0)),
        is_tiled(d.has(kTileWidth) || d.has(kTileHeight) || d.has(kTileOffsets)) {}

  bool have_one_of(std::initializer_list<uint32_t> sizes) const {
    return std::find(sizes.begin(), sizes.end(), bits) != sizes.end();
  }
  bool have_plausible_sizes(const Directory& d) const {
    constexpr uint64_t kMostInRow = uint64_t(1) << 28, kMostInTile = uint64_t(1) << 24;
    if (width == 0 || height == 0 || width > INT32_MAX || height > INT32_MAX) return false;
    if (samples == 0 || uint64_t(width) * samples > kMostInRow) return false;
    if (!is_tiled) return true;
    return tile_width > 0 && tile_height > 0 && uint64_t(tile_width) * tile_height <= kMostInTile &&
           d.value_or(kTileDepth, 1) == 1;
  }
  bool have_known_samples() const {
    switch (format) {
      case kFloat:
        return have_one_of({16, 32}) || (!is_tiled && bits == 64);  // OpenImageIO converts no tiles of 64 bits
      case kSigned:
        return have_one_of({8, 16, 32});
      case kUnsigned:
        return have_one_of({8, 16, 32}) || (!is_tiled && have_one_of({1, 2, 4, 6, 10, 12, 14, 24}));
      default:
        return false;
    }
  }
  bool have_known_colors(const Directory& d) const {
    const bool is_unsigned = format == kUnsigned;
    switch (photometric) {
      case kWhiteIsZero:
        return samples == 1 && is_unsigned && bits <= 16;
      case kBlackIsZero:
      case kRgb:
        return true;
      case kPalette:
        return samples == 1 && is_unsigned && have_one_of({1, 2, 4, 8, 16}) && d.count(kColorMap) == size_t(3) << bits;
      case kSeparated:
        return samples == 4 && is_unsigned && have_one_of({8, 16}) && !is_tiled && d.value_or(kInkSet, 1) == 1;
      case kYCbCr:
        return samples == 3 && is_unsigned && bits == 8;
      case kCieLab:
        return samples == 3 && is_unsigned && have_one_of({8, 16});
      default:
        return false;
    }
  }
  bool have_known_compression() const {
    if (compression == kJpeg) return (samples == 1 || samples == 3 || samples == 4) && bits == 8;
    return compression != kOldJpeg;
  }

  const uint32_t width, height, samples, bits, stored_format, format, photometric, compression, tile_width, tile_height;
  const bool is_tiled;
};

}  // namespace

int exif_orientation(std::span<const uint8_t> exif) {
  constexpr std::string_view kSignature("Exif\0\0", 6);
  constexpr size_t kHeader = 8;
  const std::string_view text(reinterpret_cast<const char*>(exif.data()), exif.size());
  if (text.starts_with(kSignature)) exif = exif.subspan(kSignature.size());
  if (exif.size() < kHeader || exif[0] != exif[1] || (exif[0] != 'I' && exif[0] != 'M')) return 1;
  Directory directory(exif);
  if (!directory.read()) return 1;
  const uint32_t orientation = directory.value_or(kOrientation, 1);
  return orientation >= 1 && orientation <= 8 ? int(orientation) : 1;
}

std::vector<uint8_t> essential_tiff(std::span<const uint8_t> file, std::string& error) {
  constexpr size_t kHeader = 8;
  const auto fail = [&](const char* reason) {
    error = reason;
    return std::vector<uint8_t>();
  };
  if (file.size() < kHeader) return fail("the file is cut off");
  if (file.size() > UINT32_MAX - 4096) return fail("the file is larger than 4 GB");
  Directory directory(file);
  if (!directory.read()) return fail("the file is cut off inside its directory");
  const Pixels pixels(directory);
  if (!pixels.have_plausible_sizes(directory)) return fail("its size, or that of its tiles, is none that is read");
  if (directory.value_or(kDepth, 1) != 1) return fail("it is a volume");
  if (!directory.are_all(kBits, pixels.bits) || !directory.are_all(kSampleFormat, pixels.stored_format) ||
      !pixels.have_known_samples())
    return fail("its samples are of a kind that is not read (8, 16 or 32 bits are, and floats of 64 bits in strips)");
  if (!pixels.have_known_colors(directory))
    return fail("its colours are of a kind that is not read (grey and RGB are)");
  if (!pixels.have_known_compression()) return fail("its compression is none that is read (LZW and ZIP are)");
  // OpenImageIO takes 8 bits for those that are not given, and counts with -1 rows where they are not, or by the usual
  // 2^32 - 1 for "all".
  std::map<uint16_t, uint32_t> numbers;
  if (pixels.stored_format == kUntyped) directory.remove(kSampleFormat);
  if (!directory.has(kBits)) numbers[kBits] = pixels.bits;
  if (!pixels.is_tiled)
    numbers[kRowsPerStrip] = std::min(directory.value_or(kRowsPerStrip, pixels.height), pixels.height);
  // Some colours are read as libtiff turns them, others as they are stored: the caller turns all of them.
  if (directory.has(kOrientation)) numbers[kOrientation] = 1;
  return directory.file_with(numbers);
}

}  // namespace alabaster
