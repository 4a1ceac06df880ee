// Pages of the manual and Python's stub of fields. Internal to this room.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>

namespace alabaster::hd::host {

/// The properties of a schema that is made of a table, by name. Empty: there is none.
nlohmann::ordered_json TableProperties(const std::string& schema);

/// Adds the pages and the stub, by their paths in the sources.
void AddParameterPages(std::map<std::string, std::string>* files);

}  // namespace alabaster::hd::host
