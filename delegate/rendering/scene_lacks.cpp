#include "delegate/rendering/scene_lacks.h"

#include <algorithm>
#include <string_view>

namespace alabaster::hd::rendering {
namespace {

constexpr size_t kAll = ~size_t(0);  // instances

template <class Counts>
size_t count_in(const Counts& counts, const typename Counts::key_type& key) {
  const auto found = counts.find(key);
  return found == counts.end() ? 0 : found->second;
}

template <class Counts>
bool are_within(const Counts& few, const Counts& many) {
  return std::all_of(few.begin(), few.end(), [&](const auto& one) { return one.second <= count_in(many, one.first); });
}

}  // namespace

void SceneLacks::add(const SceneSnapshot& snapshot) {
  for (const MemoryLack& lack : snapshot.lacks) {
    if (!changes_picture(lack.kind))
      unoptimized_[{lack.name, lack.kind}] = lack.count;
    else if (size_t& count = left_out_[lack.name]; count != kAll)
      count += lack.count;
  }
}

void SceneLacks::add(const prims::SceneFaults& faults, const SceneDescription& scene) {
  if (std::none_of(faults.begin(), faults.end(), [](const auto& fault) { return !fault.second.input; })) return;
  std::set<std::string_view> drawn;
  for (const InstanceDescription& instance : scene.instances) drawn.insert(instance.name);
  for (const InstanceArrayDescription& array : scene.arrays) drawn.insert(array.look.name);
  for (const auto& [prim, fault] : faults) {
    if (fault.input) continue;
    if (drawn.contains(prim.str()))
      altered_.insert(prim.str());
    else
      left_out_[prim.str()] = kAll;
  }
}

bool SceneLacks::shows_all_of(const SceneLacks& other) const {
  return are_within(left_out_, other.left_out_) &&
         std::all_of(altered_.begin(), altered_.end(), [&](const std::string& prim) {
           return other.altered_.contains(prim) || count_in(other.left_out_, prim) == kAll;
         });
}

bool SceneLacks::is_better_than(const SceneLacks& other) const {
  if (!shows_all_of(other)) return false;
  return !other.shows_all_of(*this) ||
         (are_within(unoptimized_, other.unoptimized_) && !are_within(other.unoptimized_, unoptimized_));
}

}  // namespace alabaster::hd::rendering
