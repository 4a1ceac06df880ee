#include "delegate/description/name_match.h"

#include <fnmatch.h>

#include "delegate/support/lookup.h"

namespace alabaster::hd::description {
namespace {

// The last part of a path that is more than a number: numbers tell the meshes of a node apart.
std::string last_word(const std::string& path) {
  const size_t letter = path.find_last_not_of("0123456789/");
  if (letter == std::string::npos) return path;
  const size_t begin = path.rfind('/', letter) + 1;
  return path.substr(begin, path.find('/', letter) - begin);
}

}  // namespace

void NameIndex::add(const Path& path, const std::string& name) {
  for (const std::string& known : {path.str(), name, last_word(path.str())}) prims_[known].insert(path);
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
  for (const std::string& known : {path.str(), scene.GetName(path), last_word(path.str())})
    if (fnmatch(pattern.c_str(), known.c_str(), 0) == 0) return true;
  return false;
}

std::vector<size_t> matching_subsets(const std::string& pattern, const MeshTopology& topology) {
  std::vector<size_t> found;
  for (size_t i = 0; i < topology.geomSubsets.size(); ++i)
    if (fnmatch(pattern.c_str(), topology.geomSubsets[i].id.str().c_str(), 0) == 0) found.push_back(i);
  return found;
}

}  // namespace alabaster::hd::description
