#include "delegate/description/name_match.h"

#include <fnmatch.h>

#include <algorithm>

#include "delegate/description/scene_names.h"
#include "delegate/support/lookup.h"

namespace alabaster::hd::description {
namespace {

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

void NameIndex::add(const Path& path, bool is_mesh) {
  const std::string part = component(path.str(), is_mesh);
  for (const std::string& name : {path.str(), part, without_index(part)}) prims_[name].insert(path);
}

void NameIndex::add_subsets(const Path& path, const MeshTopology& topology) {
  for (size_t i = 0; i < topology.geomSubsets.size(); ++i)
    subsets_[topology.geomSubsets[i].id.str()][path].push_back(i);
}

std::vector<Path> NameIndex::find(const std::string& name) const {
  std::set<Path> found;
  if (const auto* prims = support::find_in(prims_, name)) found = *prims;
  if (const auto* meshes = support::find_in(subsets_, name))
    for (const auto& [path, places] : *meshes) found.insert(path);
  return {found.begin(), found.end()};
}

std::vector<size_t> NameIndex::find_subsets(const std::string& name, const Path& mesh) const {
  const auto* meshes = support::find_in(subsets_, name);
  return meshes ? support::value_in(*meshes, mesh) : std::vector<size_t>();
}

bool is_plain_name(const std::string& pattern) {
  return pattern.find_first_of("*?[\\") == std::string::npos;
}

std::string AuthoredName(const Path& path, bool is_mesh) {
  return without_index(component(path.str(), is_mesh));
}

bool matches(const std::string& pattern, const Path& path, bool is_mesh) {
  const std::string part = component(path.str(), is_mesh);
  for (const std::string& name : {path.str(), part, without_index(part)})
    if (fnmatch(pattern.c_str(), name.c_str(), 0) == 0) return true;
  return false;
}

std::vector<size_t> matching_subsets(const std::string& pattern, const MeshTopology& topology) {
  std::vector<size_t> found;
  for (size_t i = 0; i < topology.geomSubsets.size(); ++i)
    if (fnmatch(pattern.c_str(), topology.geomSubsets[i].id.str().c_str(), 0) == 0) found.push_back(i);
  return found;
}

}  // namespace alabaster::hd::description
