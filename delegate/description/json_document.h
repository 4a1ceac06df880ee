// A JSON text together with the line that each of its elements stands on, so that errors can name the place.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>

namespace alabaster::hd::description {

struct JsonDocument {
  nlohmann::json value;
  std::string origin;                   // file, or what else it came from: shown to people
  std::map<std::string, size_t> lines;  // JSON pointer -> line; empty: the origin has no lines

  /// "scene.json:12 /materials/0/set"; the origin alone if it has no lines.
  std::string place(const std::string& pointer) const;
};

/// Parses strictly (no comments, no duplicate keys, at most 64 levels). False: *error says what is wrong and on which
/// line.
bool parse_json(const std::string& text, const std::string& origin, JsonDocument* document, std::string* error);

/// `parent` with one more step; escapes as RFC 6901 wants it.
std::string pointer_append(const std::string& parent, const std::string& step);

}  // namespace alabaster::hd::description
