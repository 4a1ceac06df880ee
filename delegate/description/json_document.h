// A JSON text together with the line of each of its elements, so that errors can name the place.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>

namespace alabaster::hd::description {

struct JsonDocument {
  nlohmann::json value;
  std::string origin;                   // the file or argument it came from, as shown to people
  std::map<std::string, size_t> lines;  // JSON pointer -> line; empty if the origin has no lines

  /// "scene.json:12 /materials/0/set"; the origin alone if it has no lines.
  std::string place(const std::string& pointer) const;
};

/// Parses strictly (no comments, no duplicate keys, at most 64 levels). False if the text is invalid; *error then names
/// the fault and its line.
bool parse_json(const std::string& text, const std::string& origin, JsonDocument* document, std::string* error);

/// `parent` with one more step, escaped as RFC 6901 requires.
std::string pointer_append(const std::string& parent, const std::string& step);

}  // namespace alabaster::hd::description
