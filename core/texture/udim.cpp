#include "core/texture/udim.h"

#include <algorithm>
#include <filesystem>
#include <string_view>

namespace alabaster {
namespace {

constexpr std::string_view kMark = "<UDIM>";
constexpr int kFirst = 1001, kColumns = 10;

UdimTile tile_of(int number, std::string path) {
  return {{(number - kFirst) % kColumns, (number - kFirst) / kColumns}, std::move(path)};
}

// The number that stands in `name` between the two parts of the pattern; 0: none.
int number_in(std::string_view name, std::string_view before, std::string_view after) {
  if (name.size() != before.size() + 4 + after.size() || !name.starts_with(before) || !name.ends_with(after)) return 0;
  int number = 0;
  for (const char c : name.substr(before.size(), 4)) {
    if (c < '0' || c > '9') return 0;
    number = 10 * number + (c - '0');
  }
  return number;
}

}  // namespace

std::vector<UdimTile> udim_tiles(const std::string& path) {
  namespace fs = std::filesystem;
  const fs::path whole(path);
  const std::string pattern = whole.filename().string();
  const size_t mark = pattern.find(kMark);
  std::vector<UdimTile> tiles;
  if (mark == std::string::npos) return tiles;
  const std::string_view text = pattern, before = text.substr(0, mark), after = text.substr(mark + kMark.size());
  std::error_code error;
  const fs::path folder = whole.parent_path();
  for (fs::directory_iterator it(folder.empty() ? fs::path(".") : folder, error), end; !error && it != end;
       it.increment(error)) {
    const int number = number_in(it->path().filename().string(), before, after);
    if (number >= kFirst) tiles.push_back(tile_of(number, (folder / it->path().filename()).string()));
  }
  std::sort(tiles.begin(), tiles.end(), [](const UdimTile& a, const UdimTile& b) { return a.path < b.path; });
  return tiles;
}

std::vector<UdimTile> udim_tiles(const std::string& path, const std::vector<uint8_t>& set) {
  constexpr std::string_view kMagic = "UDIM";
  constexpr size_t kHead = 12;
  std::vector<UdimTile> tiles;
  if (set.size() < kMagic.size() || !std::equal(kMagic.begin(), kMagic.end(), set.begin())) return {};
  const auto number = [&](size_t at, size_t bytes) {
    uint64_t value = 0;
    for (size_t i = 0; i < bytes; ++i) value |= uint64_t(set[at + i]) << (8 * i);
    return value;
  };
  for (size_t at = kMagic.size(); at < set.size();) {
    if (set.size() - at < kHead) return {};
    const uint64_t place = number(at, 4), size = number(at + 4, 8);
    at += kHead;
    if (place < uint64_t(kFirst) || place > 9999 || size > set.size() - at) return {};
    std::string name = path;
    if (const size_t mark = name.rfind(kMark); mark != std::string::npos)
      name.replace(mark, kMark.size(), std::to_string(place));
    tiles.push_back(tile_of(int(place), std::move(name)));
    const auto begin = set.begin() + std::ptrdiff_t(at);
    tiles.back().bytes = std::make_shared<const std::vector<uint8_t>>(begin, begin + std::ptrdiff_t(size));
    at += size;
  }
  return tiles;
}

}  // namespace alabaster
