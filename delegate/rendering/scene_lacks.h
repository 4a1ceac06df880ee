// The parts that a scene is drawn without because memory ran out, to compare tries to build the same scene.
#pragma once

#include <map>
#include <set>
#include <string>
#include <utility>

#include "core/scene/scene.h"
#include "delegate/prims/records.h"

namespace alabaster::hd::rendering {

class SceneLacks {
 public:
  void add(const SceneSnapshot& snapshot);
  /// The faults for want of memory, of prims that `scene` was translated from.
  void add(const prims::SceneFaults& faults, const SceneDescription& scene);

  bool empty() const { return left_out_.empty() && altered_.empty() && unoptimized_.empty(); }
  /// True if the picture has all parts that it has with `other`.
  bool shows_all_of(const SceneLacks& other) const;
  /// True if the picture has more parts than with `other` and loses none, or has the same in less time.
  bool is_better_than(const SceneLacks& other) const;

 private:
  std::map<std::string, size_t> left_out_;                          // instances by prim
  std::set<std::string> altered_;                                   // prims: meshes that are drawn undeformed
  std::map<std::pair<std::string, LackKind>, size_t> unoptimized_;  // instances; the picture is the same
};

}  // namespace alabaster::hd::rendering
