// Names as people type them: globs over prims.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "delegate/host/retained_scene_delegate.h"

namespace alabaster::hd::description {

/// True if `pattern` (a glob with * and ?) matches the prim's path, its artist's name, or the last part of its
/// path that is more than a number ("/gltf/bust/nodes/3_head/0": "3_head").
bool matches(const std::string& pattern, const Path& path, const host::RetainedSceneDelegate& scene);

/// The subsets of a mesh that `pattern` matches by their paths, as places in the topology. A pattern that matches the
/// mesh is not meant for its subsets.
std::vector<size_t> matching_subsets(const std::string& pattern, const MeshTopology& topology);

/// True of a pattern that matches only itself.
bool is_plain_name(const std::string& pattern);

/// The prims of one kind by all names that `matches` knows, so that many plain names are found without a walk for each.
class NameIndex {
 public:
  void add(const Path& path, const std::string& name);
  void add_subsets(const Path& path, const MeshTopology& topology);
  /// In the order of paths. Meshes that have a subset of the name, too.
  std::vector<Path> find(const std::string& name) const;
  std::vector<size_t> find_subsets(const std::string& name, const Path& mesh) const;

 private:
  std::map<std::string, std::set<Path>> prims_;
  std::map<std::string, std::map<Path, std::vector<size_t>>> subsets_;  // by their paths
};

}  // namespace alabaster::hd::description
