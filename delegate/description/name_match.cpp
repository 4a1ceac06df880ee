#include "delegate/description/name_match.h"

#include <fnmatch.h>

#include <algorithm>
#include <cctype>

namespace alabaster::hd::description {
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

std::string component(const std::string& path, bool before_last) {
  std::string rest = path;
  if (before_last) rest.resize(std::min(rest.rfind('/'), rest.size()));
  const size_t slash = rest.rfind('/');
  return slash == std::string::npos ? rest : rest.substr(slash + 1);
}

std::string without_index(const std::string& name) {
  const size_t digits = name.find_first_not_of("0123456789");
  if (digits == 0 || digits == std::string::npos || name[digits] != '_') return name;
  return name.substr(digits + 1);
}

}  // namespace

std::string nearest_name(const std::string& name, const std::vector<std::string>& candidates) {
  const auto nearest = std::min_element(candidates.begin(), candidates.end(), [&](const auto& a, const auto& b) {
    return distance(name, a) < distance(name, b);
  });
  return nearest == candidates.end() ? "" : *nearest;
}

std::string suggestion(const std::string& name, const std::vector<std::string>& candidates) {
  const std::string nearest = nearest_name(name, candidates);
  return nearest.empty() ? "" : " Did you mean '" + nearest + "'?";
}

std::string authored_name(const Path& path, bool is_mesh) {
  return without_index(component(path.str(), is_mesh));
}

bool matches(const std::string& pattern, const Path& path, bool is_mesh) {
  const std::string part = component(path.str(), is_mesh);
  for (const std::string& name : {path.str(), part, without_index(part)})
    if (fnmatch(pattern.c_str(), name.c_str(), 0) == 0) return true;
  return false;
}

}  // namespace alabaster::hd::description
