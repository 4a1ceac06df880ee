// Entries of maps, and numbers and texts of dictionaries and of parameters, by name.
#pragma once

#include <string>

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

/// The first of the list of that name; null where there is none.
template <class Map, class Key>
auto first_in(const Map& lists, const Key& name) -> decltype(&lists.find(name)->second.front()) {
  const auto* list = find_in(lists, name);
  return list && !list->empty() ? &list->front() : nullptr;
}

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
