#include "delegate/support/nearest_name.h"

#include <algorithm>
#include <cctype>

namespace alabaster::hd::support {
namespace {

// Levenshtein distance in half steps: a wrong letter costs 2, wrong case 1.
size_t distance(const std::string& a, const std::string& b) {
  std::vector<size_t> row(b.size() + 1);
  for (size_t j = 0; j <= b.size(); ++j) row[j] = 2 * j;
  for (size_t i = 1; i <= a.size(); ++i) {
    size_t diagonal = row[0];
    row[0] = 2 * i;
    for (size_t j = 1; j <= b.size(); ++j) {
      const auto lower = [](char c) { return std::tolower(static_cast<unsigned char>(c)); };
      const size_t change = a[i - 1] == b[j - 1] ? 0 : lower(a[i - 1]) == lower(b[j - 1]) ? 1 : 2;
      const size_t best = std::min({diagonal + change, row[j] + 2, row[j - 1] + 2});
      diagonal = row[j];
      row[j] = best;
    }
  }
  return row[b.size()];
}

}  // namespace

std::string NearestName(const std::string& name, const std::vector<std::string>& known) {
  constexpr size_t kLongestName = 200;  // beyond it nobody mistyped a name, and the search would take its square
  std::string nearest;
  if (name.size() > kLongestName) return nearest;
  // A name with its namespace in USD.
  const std::string within = name.substr(name.find(':') + 1);
  if (std::find(known.begin(), known.end(), within) != known.end()) return within;
  size_t fewest = 2 * std::max(size_t(2), name.size() / 3) + 1;
  constexpr size_t kMostCells = 100'000'000;  // of all tables of distances
  size_t cells = 0;
  for (const std::string& candidate : known) {
    const size_t longer = std::max(name.size(), candidate.size()), shorter = std::min(name.size(), candidate.size());
    if (2 * (longer - shorter) >= fewest) continue;
    if ((cells += longer * shorter) > kMostCells) break;
    const size_t steps = distance(name, candidate);
    // A distance of the whole name shares nothing with it.
    if (steps >= fewest || steps >= 2 * longer) continue;
    fewest = steps;
    nearest = candidate;
  }
  return nearest;
}

std::string DidYouMean(const std::string& name, const std::vector<std::string>& known, const std::string& otherwise) {
  const std::string nearest = NearestName(name, known);
  return nearest.empty() ? otherwise : "; did you mean '" + nearest + "'?";
}

}  // namespace alabaster::hd::support
