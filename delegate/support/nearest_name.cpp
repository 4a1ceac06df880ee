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

constexpr const char* kSeparators = ":./";

using Names = std::vector<std::string>;

/// The known name that is a tail of `name` behind a separator: "inputs:roughness".
std::string known_tail(const std::string& name, const Names& known) {
  for (size_t at = name.find_first_of(kSeparators); at != std::string::npos;
       at = name.find_first_of(kSeparators, at + 1))
    if (const std::string tail = name.substr(at + 1); std::find(known.begin(), known.end(), tail) != known.end())
      return tail;
  return {};
}

/// The shortest known name that `name` has before a separator ("roughness.r"), or that has `name` before or behind one
/// ("points" of "primvars:points").
std::string known_beside(const std::string& name, const Names& known) {
  Names before, behind;
  for (const char* separator = kSeparators; *separator && !name.empty(); ++separator)
    before.push_back(*separator + name), behind.push_back(name + *separator);
  const auto is_beside = [&](const std::string& one) {
    if (name.size() > one.size() && name.starts_with(one))
      return !one.empty() && (name[one.size()] == ':' || name[one.size()] == '.');  // not above in a path
    return std::any_of(before.begin(), before.end(), [&](const std::string& part) { return one.ends_with(part); }) ||
           std::any_of(behind.begin(), behind.end(), [&](const std::string& part) { return one.starts_with(part); });
  };
  std::string found;
  for (const std::string& one : known)
    if (is_beside(one) && (found.empty() || one.size() < found.size())) found = one;
  return found;
}

}  // namespace

std::string NearestName(const std::string& name, const std::vector<std::string>& known) {
  constexpr size_t kLongestName = 200;  // beyond it nobody mistyped a name, and the search would take its square
  if (name.size() > kLongestName) return {};
  std::string nearest = known_tail(name, known);
  if (!nearest.empty()) return nearest;
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
  if (nearest.empty()) nearest = known_beside(name, known);
  constexpr size_t kLeastLetters = 6;  // shorter ends, as those of files, are near to many names
  const size_t end = name.find_last_of(kSeparators) + 1;
  const bool has_end = end > 0 && name.size() - end >= kLeastLetters;
  return nearest.empty() && has_end ? NearestName(name.substr(end), known) : nearest;
}

std::string DidYouMean(const std::string& name, const std::vector<std::string>& known, const std::string& otherwise) {
  const std::string nearest = NearestName(name, known);
  return nearest.empty() ? otherwise : "; did you mean '" + nearest + "'?";
}

std::string Suggestion(const std::string& name, const std::vector<std::string>& known) {
  const std::string nearest = NearestName(name, known);
  return nearest.empty() ? "" : " Did you mean '" + nearest + "'?";
}

}  // namespace alabaster::hd::support
