// The lists and objects of a JSON document.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace alabaster {

using JsonPlace = nlohmann::json::json_pointer;

/// Appends the places of all lists and objects in `value` that are not empty.
inline void find_containers(const nlohmann::json& value, const JsonPlace& at, std::vector<JsonPlace>* places) {
  if (!value.is_structured() || value.empty()) return;
  places->push_back(at);
  if (value.is_array())
    for (size_t i = 0; i < value.size(); ++i) find_containers(value[i], at / i, places);
  else
    for (const auto& [key, child] : value.items()) find_containers(child, at / key, places);
}

/// A copy of `document` for each of them, in which that one is empty.
inline std::vector<std::pair<std::string, nlohmann::json>> emptied_documents(const nlohmann::json& document) {
  std::vector<JsonPlace> places;
  find_containers(document, JsonPlace(), &places);
  std::vector<std::pair<std::string, nlohmann::json>> all;
  for (const JsonPlace& place : places) {
    nlohmann::json& copy = all.emplace_back(place.to_string(), document).second;
    copy[place] = copy[place].is_array() ? nlohmann::json::array() : nlohmann::json::object();
  }
  return all;
}

}  // namespace alabaster
