#include "core/texture/exr_pieces.h"

#include <algorithm>
#include <cctype>
#include <span>
#include <string_view>

namespace alabaster {
namespace {

using Bytes = std::span<const uint8_t>;

enum Compression : uint8_t { kNone, kRle, kZips, kZip, kPiz, kPxr24, kB44, kB44a, kDwaa, kDwab };

uint64_t little_endian(Bytes bytes, size_t at, size_t count) {
  uint64_t value = 0;
  for (size_t i = count; i-- > 0;) value = value << 8 | bytes[at + i];
  return value;
}

/// The samples of a range of pixels, both ends included, of which every `step`-th has one.
uint64_t samples(int64_t from, int64_t to, int64_t step) {
  const auto down = [step](int64_t value) { return value >= 0 ? value / step : -((-value + step - 1) / step); };
  return uint64_t(down(to) - down(from - 1));
}

/// Pixels that are stored together, both ends included.
struct Range {
  int64_t x0, y0, x1, y1;
};
uint64_t columns(const ExrPart::Channel& channel, const Range& range) {
  return samples(range.x0, range.x1, channel.x_step);
}
uint64_t rows(const ExrPart::Channel& channel, const Range& range) {
  return samples(range.y0, range.y1, channel.y_step);
}
uint64_t bytes_of(const ExrPart::Channel& channel, const Range& range) {
  return columns(channel, range) * rows(channel, range) * (channel.type == kExrHalf ? 2 : 4);
}

/// The bytes that runs stand for.
uint64_t run_bytes(Bytes runs) {
  uint64_t total = 0;
  for (size_t at = 0; at < runs.size();) {
    const auto count = int8_t(runs[at]);
    total += count < 0 ? uint64_t(-count) : uint64_t(count) + 1;
    at += count < 0 ? size_t(1 - count) : 2;
  }
  return total;
}

/// A rule of DWA: how channels of this name, after the last '.', and this type are stored.
struct DwaRule {
  std::string_view name;
  uint32_t type;
  uint32_t scheme;
  bool any_case;
};
enum : uint32_t { kUnknown = 0, kLossy = 1, kRuns = 2 };

std::vector<DwaRule> rules_before_version_2() {
  std::vector<DwaRule> rules;
  for (const uint32_t type : {kExrHalf, 2u})
    for (const char* name : {"r", "red", "g", "grn", "green", "b", "blu", "blue", "y", "by", "ry"})
      rules.push_back({name, type, kLossy, true});
  for (const uint32_t type : {0u, kExrHalf, 2u}) rules.push_back({"a", type, kRuns, true});
  return rules;
}

/// False if the rules are cut off.
bool read_rules(Bytes bytes, std::vector<DwaRule>& rules) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  for (size_t at = 0; at < text.size();) {
    const size_t end = text.find('\0', at);
    if (end == std::string_view::npos || text.size() - end < 3) return false;
    rules.push_back(
        {text.substr(at, end - at), bytes[end + 2], uint32_t(bytes[end + 1]) >> 2 & 3, (bytes[end + 1] & 1) != 0});
    at = end + 3;
  }
  return true;
}

uint32_t scheme_of(const ExrPart::Channel& channel, const std::vector<DwaRule>& rules) {
  const std::string own = channel.name.substr(channel.name.rfind('.') + 1);
  std::string lower = own;
  std::transform(lower.begin(), lower.end(), lower.begin(), [](unsigned char c) { return char(std::tolower(c)); });
  uint32_t scheme = kUnknown;
  for (const DwaRule& rule : rules)  // the last one counts
    if (rule.type == channel.type && rule.name == (rule.any_case ? lower : own)) scheme = rule.scheme;
  return scheme;
}

/// True if the piece's counts are those of its channels. Where a count is right OpenEXR finds what is missing, but for
/// channels of no known kind.
bool fits_dwa(Bytes piece, const ExrPart& part, const Range& range, const ImageFunctions& images) {
  enum { kVersion, kUnknownBytes, kUnknownStored, kAcStored, kDcStored, kRunsStored, kRunsSize, kRunBytes, kAc, kDc };
  constexpr size_t kCounts = 11, kHeader = kCounts * 8;
  if (piece.size() < kHeader) return false;
  const auto count = [piece](size_t i) { return little_endian(piece, 8 * i, 8); };
  std::vector<DwaRule> rules;
  size_t at = kHeader;
  if (count(kVersion) < 2) {
    rules = rules_before_version_2();
  } else {
    const size_t size = piece.size() < kHeader + 2 ? 0 : little_endian(piece, kHeader, 2);
    if (size < 2 || size > piece.size() - kHeader || !read_rules(piece.subspan(kHeader + 2, size - 2), rules))
      return false;
    at += size;
  }
  uint64_t unknown = 0, runs = 0, blocks = 0;
  for (const ExrPart::Channel& channel : part.channels) {
    const uint32_t scheme = scheme_of(channel, rules);
    if (scheme == kLossy)
      blocks += ((columns(channel, range) + 7) / 8) * ((rows(channel, range) + 7) / 8);
    else
      (scheme == kRuns ? runs : unknown) += bytes_of(channel, range);
  }
  if (count(kUnknownBytes) != unknown || count(kRunBytes) != runs || count(kDc) != blocks) return false;
  return unknown == 0 || (count(kUnknownStored) <= piece.size() - at &&
                          images.inflates_to(piece.subspan(at, size_t(count(kUnknownStored))), unknown));
}

class PieceChecker {
 public:
  PieceChecker(const FileBytes& file, const ExrPart& part, const ImageFunctions& images)
      : file_(file), part_(part), images_(images) {}

  /// Nothing, or why not.
  std::string fault() {
    const auto& window = part_.window;
    const Range all{window[0], window[1], window[2], window[3]};
    if (all.x0 > all.x1 || all.y0 > all.y1) return {};  // OpenEXR refuses these, and steps below 1
    for (const ExrPart::Channel& channel : part_.channels)
      if (channel.x_step < 1 || channel.y_step < 1) return {};
    const int64_t width = part_.is_tiled ? part_.tile_width : all.x1 - all.x0 + 1;
    const int64_t height = part_.is_tiled ? part_.tile_height : part_.lines;
    if (width == 0 || height == 0) return {};
    uint64_t number = 0;
    for (int64_t y = all.y0; y <= all.y1; y += height)
      for (int64_t x = all.x0; x <= all.x1; x += width, ++number)
        if (!fits(number, {x, y, std::min(x + width - 1, all.x1), std::min(y + height - 1, all.y1)}))
          return "piece " + std::to_string(number) + " is missing or too short";
    return {};
  }

 private:
  bool fits(uint64_t number, const Range& range) {
    std::array<uint8_t, 24> head{};
    const size_t place_at = part_.is_multipart ? 4 : 0, size_at = place_at + (part_.is_tiled ? 16 : 4);
    if (!read(part_.offsets + 8 * number, head.data(), 8)) return false;
    const uint64_t at = little_endian(head, 0, 8);
    if (!read(at, head.data(), size_at + 4)) return false;
    const auto value = [&](size_t i) { return int64_t(int32_t(little_endian(head, i, 4))); };
    if (part_.is_multipart && value(0) != int64_t(part_.number)) return false;
    if (part_.is_tiled) {
      if (value(place_at) != (range.x0 - part_.window[0]) / part_.tile_width ||
          value(place_at + 4) != (range.y0 - part_.window[1]) / part_.tile_height || value(place_at + 8) != 0 ||
          value(place_at + 12) != 0)
        return false;
    } else if (value(place_at) != range.y0) {
      return false;
    }
    return fits(at + size_at + 4, uint32_t(value(size_at)), range);
  }

  /// `size` bytes from `at` on.
  bool fits(uint64_t at, uint32_t size, const Range& range) {
    uint64_t whole = 0;
    for (const ExrPart::Channel& channel : part_.channels) whole += bytes_of(channel, range);
    if (whole == 0 || (size >= whole && size <= INT32_MAX)) return size <= file_.size - at;  // stored as it is
    if (part_.compression == kNone || size == 0 || size >= whole) return false;
    const bool checked_there = part_.compression >= kPiz && part_.compression <= kB44a;
    if (checked_there) return true;
    piece_.resize(std::min<uint64_t>(size, file_.size));
    if (!read(at, piece_.data(), size)) return false;
    switch (part_.compression) {
      case kRle:
        return run_bytes(piece_) == whole;
      case kZips:
      case kZip:
        return images_.inflates_to(piece_, whole);
      case kDwaa:
      case kDwab:
        return fits_dwa(piece_, part_, range, images_);
      default:
        return true;  // OpenEXR does not know it
    }
  }

  bool read(uint64_t offset, void* out, size_t count) const {
    return offset <= file_.size && count <= file_.size - offset && file_.read(offset, out, count);
  }

  const FileBytes& file_;
  const ExrPart& part_;
  const ImageFunctions& images_;
  std::vector<uint8_t> piece_;
};

}  // namespace

bool check_exr_pieces(const FileBytes& file, const ExrPart& part, const ImageFunctions& images, ImageFault* fault) {
  if (part.is_deep) return true;  // not read
  if (part.compression > kDwab) {
    *fault = {"texture.format", "its compression is of a kind that is not read; export it with ZIP, PIZ or DWAA"};
    return false;
  }
  const std::string reason = PieceChecker(file, part, images).fault();
  if (!reason.empty()) *fault = {"texture.damaged", reason + "; export or copy the image again"};
  return reason.empty();
}

}  // namespace alabaster
