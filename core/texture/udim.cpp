#include "core/texture/udim.h"

#include <algorithm>
#include <filesystem>
#include <string_view>

namespace alabaster {
namespace {

constexpr std::string_view kMark = "<UDIM>";
constexpr int kFirst = 1001, kColumns = 10;

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
    const int number = number_in(it->path().filename().string(), before, after) - kFirst;
    if (number >= 0)
      tiles.push_back({{number % kColumns, number / kColumns}, (folder / it->path().filename()).string()});
  }
  std::sort(tiles.begin(), tiles.end(), [](const UdimTile& a, const UdimTile& b) { return a.path < b.path; });
  return tiles;
}

}  // namespace alabaster
