// Entries of maps, and numbers and texts of dictionaries and of parameters, by name.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace alabaster::hd::support {

/// The value of that name in a map; null where there is none.
template <class Map, class Key>
auto find_in(Map& values, const Key& name) -> decltype(&values.find(name)->second) {
  const auto found = values.find(name);
  return found == values.end() ? nullptr : &found->second;
}

/// A copy of it; an empty one where there is none.
template <class Map, class Key>
typename Map::mapped_type value_in(const Map& values, const Key& name) {
  const auto* value = find_in(values, name);
  return value ? *value : typename Map::mapped_type();
}

template <class Map>
std::vector<typename Map::key_type> keys_of(const Map& values) {
  std::vector<typename Map::key_type> keys;
  for (const auto& entry : values) keys.push_back(entry.first);
  return keys;
}

/// The first of the list of that name; null where there is none.
template <class Map, class Key>
auto first_in(const Map& lists, const Key& name) -> decltype(&lists.find(name)->second.front()) {
  const auto* list = find_in(lists, name);
  return list && !list->empty() ? &list->front() : nullptr;
}

/// Looks up names that come in ascending order, each one once: a step through the map takes less than a search. The map
/// must stay as it is. A name that comes after a greater one is not found.
template <class Map>
class AscendingLookup {
 public:
  explicit AscendingLookup(Map& values) : at_(values.begin()), end_(values.end()) {}
  /// Null: there is none of that name.
  template <class Key>
  auto find(const Key& name) -> decltype(&std::declval<Map&>().begin()->second) {
    while (at_ != end_ && !(at_->first == name) && at_->first < name) ++at_;
    return at_ != end_ && at_->first == name ? &(at_++)->second : nullptr;
  }

 private:
  decltype(std::declval<Map&>().begin()) at_, end_;
};

/// The number of that name in a map of Values; `fallback` where there is none.
template <class Map>
double number_in(const Map& values, const char* name, double fallback = 0) {
  const auto* value = find_in(values, name);
  return value ? value->number_or(fallback) : fallback;
}

template <class Map>
std::string text_in(const Map& values, const char* name) {
  const auto* value = find_in(values, name);
  return value ? value->text_or("") : std::string();
}

}  // namespace alabaster::hd::support
