#include "delegate/description/name_match.h"

#include <fnmatch.h>

#include "delegate/support/lookup.h"

namespace alabaster::hd::description {

void NameIndex::add(const Path& path, const std::string& name) {
  for (const std::string& known : {path.str(), name}) prims_[known].insert(path);
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

bool matches(const std::string& pattern, const Path& path, const host::RetainedSceneDelegate& scene) {
  return fnmatch(pattern.c_str(), path.str().c_str(), 0) == 0 ||
         fnmatch(pattern.c_str(), scene.GetName(path).c_str(), 0) == 0;
}

std::vector<size_t> matching_subsets(const std::string& pattern, const MeshTopology& topology) {
  std::vector<size_t> found;
  for (size_t i = 0; i < topology.geomSubsets.size(); ++i)
    if (fnmatch(pattern.c_str(), topology.geomSubsets[i].id.str().c_str(), 0) == 0) found.push_back(i);
  return found;
}

}  // namespace alabaster::hd::description
